// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqFoundValueWidget
 * @brief   a text, or three numbers, that a user may set in place of what a file says
 *
 * Empty fields show in grey what the file says, and that holds. If one of three numbers is set, the
 * others become those of the file; if all are those, they are empty again. In a panel: panel_widget="found_value" at a string property, or at a
 * property of none or three doubles, of a proxy that has an information property of that name with
 * "Info" behind it: what the file says.
 */

#ifndef pqFoundValueWidget_h
#define pqFoundValueWidget_h

#include "pqPropertyWidget.h"

#include <QList>
#include <QVariantList>

class QLineEdit;

class pqFoundValueWidget : public pqPropertyWidget
{
  Q_OBJECT
  typedef pqPropertyWidget Superclass;
  Q_PROPERTY(QVariantList numbers READ GetNumbers WRITE SetNumbers NOTIFY numbersChanged)

public:
  pqFoundValueWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);

  QVariantList GetNumbers() const;
  void SetNumbers(const QVariantList& numbers);

Q_SIGNALS:
  void numbersChanged();

private Q_SLOTS:
  void ReadFound();
  void FillOthers();
  void EmptyIfFound();

private:
  QList<QLineEdit*> Fields;
};

#endif
