// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqRefinementStatus
 * @brief   what level of a progressive surface is shown, in the status bar
 *
 * A button with a menu: stop refining, and whether surfaces are coarse first.
 */

#ifndef pqRefinementStatus_h
#define pqRefinementStatus_h

#include "ContourProxy.h"

#include <QToolButton>

class QAction;

class pqRefinementStatus : public QToolButton
{
  Q_OBJECT
  typedef QToolButton Superclass;

public:
  explicit pqRefinementStatus(QWidget* parent = nullptr);

  /// Whether surfaces are to be coarse first; kept in the user's settings.
  bool IsCoarseFirst() const;

public Q_SLOTS:
  /// That a surface may get finer.
  void ShowBegin();
  void ShowRefinement(const isosurface::Refinement& report);
  /// How much of a file is shown exactly, while it is indexed.
  void ShowGrowth(const isosurface::Refinement& report);
  /// That a surface is as it is: final or not.
  void ShowEnd(int level, bool stopped);
  /// That there is no surface any more.
  void Clear();

Q_SIGNALS:
  void stopped();

private:
  QAction* CoarseFirst;
  QAction* Stop;
};

#endif
