// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqInformationLine
 * @brief   a line of text in the Properties panel: what an information property says
 *
 * Read anew whenever the proxy's data was updated. In a panel: panel_widget="information_line" at a
 * string property with information_only.
 */

#ifndef pqInformationLine_h
#define pqInformationLine_h

#include "pqPropertyWidget.h"

class QLabel;
class pqPropertyWidgetDecorator;

class pqInformationLine : public pqPropertyWidget
{
  Q_OBJECT
  typedef pqPropertyWidget Superclass;
  Q_PROPERTY(QString text READ GetText)

public:
  pqInformationLine(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);

  QString GetText() const;

private Q_SLOTS:
  void Read();

private:
  QLabel* Label;
  pqPropertyWidgetDecorator* Decorator = nullptr; ///< hides this line while the text is empty
  QString Text;
};

#endif
