// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqUnitDecorator
 * @brief   the unit of a number, behind its field in a panel
 *
 * In a panel: PropertyWidgetDecorator type="Unit" text="MiB" at the property. The property's label
 * stays as it is, because Python's name of the property is made of that.
 */

#ifndef pqUnitDecorator_h
#define pqUnitDecorator_h

#include "pqPropertyWidgetDecorator.h"

class pqUnitDecorator : public pqPropertyWidgetDecorator
{
  Q_OBJECT
  typedef pqPropertyWidgetDecorator Superclass;

public:
  pqUnitDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent);
};

#endif
