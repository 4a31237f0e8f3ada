// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqOtherArraysDecorator
 * @brief   shows a list of arrays without the contoured one, and not at all if it is empty
 *
 * The surface carries the isovalue under the name of the contoured array, so that array is offered
 * only if Compute Scalars is off. The widget's property hiddenArray names it. In a panel:
 * PropertyWidgetDecorator type="OtherArrays" at a property that is a list of arrays; the contoured one is
 * that of SelectInputScalars, if the proxy has it and ComputeScalars.
 */

#ifndef pqOtherArraysDecorator_h
#define pqOtherArraysDecorator_h

#include "pqPropertyWidgetDecorator.h"

class pqOtherArraysDecorator : public pqPropertyWidgetDecorator
{
  Q_OBJECT
  typedef pqPropertyWidgetDecorator Superclass;

public:
  pqOtherArraysDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent);

  bool canShowWidget(bool showAdvanced) const override;

private Q_SLOTS:
  void ExpectChange();
  void HideContoured();

private:
  bool IsEmpty = false;
};

#endif
