// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSpectrumPickBehavior
 * @brief   isovalues of a contour are picked in a contour spectrum
 *
 * - A double-click in the chart sets the isovalue that is there; with Ctrl it is added.
 * - Selected rows, of a spreadsheet view, say: a row is an isovalue; rows next to each other are a
 *   range, whose ends are two. An empty selection changes nothing.
 *
 * They are set at once, as one step to undo, on a contour of the same input, array and component:
 * the active one, or else the last one that was made.
 *
 * ParaView makes the one object when the plugin is loaded into its window.
 */

#ifndef pqSpectrumPickBehavior_h
#define pqSpectrumPickBehavior_h

#include <QObject>

#include <vector>

class pqOutputPort;
class pqPipelineSource;
class pqView;
class vtkObject;
class vtkSMSourceProxy;

class pqSpectrumPickBehavior : public QObject
{
  Q_OBJECT

public:
  using QObject::QObject;

  void OnStartup();
  void OnShutdown() {}

private Q_SLOTS:
  void Observe(pqPipelineSource* source);
  void ObserveView(pqView* view);
  void Pick(pqOutputPort* port);
  void PickPlace(vtkObject* interactor);

private:
  /// add: to the contour's own isovalues.
  void SetIsovalues(vtkSMSourceProxy* spectrum, std::vector<double> isovalues, bool add);
};

#endif
