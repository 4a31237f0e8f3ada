// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqResolutionWidget
 * @brief   a level of detail in a panel: full, 1/2, 1/4 ... of the samples along each axis
 *
 * In a panel: panel_widget="resolution" at a level, whose domain is the range of levels.
 */

#ifndef pqResolutionWidget_h
#define pqResolutionWidget_h

#include "pqPropertyWidget.h"

class QComboBox;

class pqResolutionWidget : public pqPropertyWidget
{
  Q_OBJECT
  typedef pqPropertyWidget Superclass;
  Q_PROPERTY(int level READ GetLevel WRITE SetLevel NOTIFY levelChanged)
  Q_PROPERTY(int coarsest READ GetCoarsest)

public:
  pqResolutionWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);

  int GetLevel() const;
  void SetLevel(int level);
  /// The last level in the list.
  int GetCoarsest() const;

Q_SIGNALS:
  void levelChanged();

private Q_SLOTS:
  /// Lists the levels of the domain, and the level that is chosen.
  void ListLevels();

private:
  QComboBox* Levels;
};

#endif
