// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqIsosurfaceMenuBehavior
 * @brief   makes what the plugin offers findable, and what it shows readable
 *
 * - The tool bar of the filters is the last one. ParaView makes that of a plugin which is loaded at its
 *   start (PV_PLUGIN_PATH, Auto Load) before its own, in a full line, where its buttons do not show.
 * - A new chart of a contour spectrum shows the triangles alone, on a logarithmic axis where they
 *   span more than two decades, with the axes' titles.
 *
 * ParaView makes the one object when the plugin is loaded into its window.
 */

#ifndef pqIsosurfaceMenuBehavior_h
#define pqIsosurfaceMenuBehavior_h

#include <QObject>

class pqDataRepresentation;
class pqRepresentation;
class pqView;

class pqIsosurfaceMenuBehavior : public QObject
{
  Q_OBJECT

public:
  using QObject::QObject;

  void OnStartup();
  void OnShutdown() {}

private Q_SLOTS:
  void MoveToolBar();
  void ObserveView(pqView* view);
  void ArrangeChart(pqRepresentation* representation);
  void ExpectReset();
  void KeepRanges();
};

#endif
