// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSeveralComponentsDecorator
 * @brief   shows a choice of components only where there is one: not for scalars
 *
 * In a panel: PropertyWidgetDecorator type="SeveralComponents" at a property with a
 * NumberOfComponentsDomain.
 */

#ifndef pqSeveralComponentsDecorator_h
#define pqSeveralComponentsDecorator_h

#include "pqPropertyWidgetDecorator.h"

class pqSeveralComponentsDecorator : public pqPropertyWidgetDecorator
{
  Q_OBJECT
  typedef pqPropertyWidgetDecorator Superclass;

public:
  pqSeveralComponentsDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent);

  bool canShowWidget(bool showAdvanced) const override;
};

#endif
