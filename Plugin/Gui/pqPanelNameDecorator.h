// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqPanelNameDecorator
 * @brief   another name of a property in panels
 *
 * In a panel: PropertyWidgetDecorator type="PanelName" text="Keep the largest (0: all)" at the property. The
 * property's label stays as it is, because Python's name of the property is made of that. A choice gets no wider than
 * the panel.
 */

#ifndef pqPanelNameDecorator_h
#define pqPanelNameDecorator_h

#include "pqPropertyWidgetDecorator.h"

class pqPanelNameDecorator : public pqPropertyWidgetDecorator
{
  Q_OBJECT
  typedef pqPropertyWidgetDecorator Superclass;

public:
  pqPanelNameDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent);

  bool eventFilter(QObject* object, QEvent* event) override;

private:
  void Rename() const;

  QString Name;
};

#endif
