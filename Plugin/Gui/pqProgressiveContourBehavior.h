// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqProgressiveContourBehavior
 * @brief   surfaces and slices that the user asks for by hand are coarse at once, and exact soon
 *
 * While ParaView applies what was changed in a Properties panel, undoes it, or goes to another time
 * by the buttons of the toolbar, every Isosurface may give a coarse surface, every Volume
 * Slice a coarse slice, and every Volume Reader (Any Size) a sample of its file (AllowCoarse).
 * pqIndexStatus sees to the latter. Scripts, state files and saved animations get exact ones.
 * Afterwards each contour or slice that is not final makes the next level beside the window
 * (PrepareRefinement); a timer asks how far it is. When it is there on all ranks, and no mouse
 * button is down, Refine and a rendering show it. Until then the view keeps what it has.
 *
 * Before the window saves data, a screenshot or an animation, all surfaces are finished. One that
 * would not fit into the server's memory is not extracted without asking.
 *
 * ParaView makes one object when its window loads the plugin.
 */

#ifndef pqProgressiveContourBehavior_h
#define pqProgressiveContourBehavior_h

#include "ContourProxy.h"

#include "vtkBoundingBox.h"
#include "vtkType.h"

#include <QElapsedTimer>
#include <QObject>
#include <QPointer>

#include <map>
#include <vector>

class QDialog;
class QMainWindow;
class pqIndexStatus;
class pqPipelineSource;
class pqRefinementStatus;
class pqSurfaceDrawing;
class pqTimer;

class pqProgressiveContourBehavior : public QObject
{
  Q_OBJECT

public:
  explicit pqProgressiveContourBehavior(QObject* parent = nullptr);

  /// Between two questions how far a surface is.
  static constexpr int PollMilliseconds = 10;
  /// The same while surfaces wait for more of a file to be indexed.
  static constexpr int GrowthMilliseconds = 100;
  /// That the ranks of a server sleep while they extract, so that their waiting for messages does
  /// not take the cores.
  static constexpr int SliceMilliseconds = 60;
  /// A surface of this number of triangles may take longer to draw than a hand should wait.
  static constexpr double LargeSurface = 1e6;
  /// A hand that has not moved for this long rests.
  static constexpr int RestMilliseconds = 150;
  /// The longest that a surface waits for a hand to rest.
  static constexpr int PatienceMilliseconds = 2000;

  void OnStartup();
  void OnShutdown();

protected:
  /// Waits for dialogs that save.
  bool eventFilter(QObject* object, QEvent* event) override;

private Q_SLOTS:
  void ObserveWindow();
  void Observe(pqPipelineSource* source);
  /// A contour or reader that the user has chosen executes before it tells that it is applied.
  void ObserveFirst(pqPipelineSource* source);
  void BeginByHand();
  void EndByHand();
  /// A button that goes to another time; until EndTime nothing is refined.
  void BeginTime();
  void EndTime();
  void RenderByHand();
  void Watch(pqPipelineSource* source);
  void Advance();
  void Stop();
  void Finish();

private:
  /// A contour whose surface may not be final.
  struct Watched
  {
    QPointer<pqPipelineSource> Source;
    bool Asked = false;       ///< whether the server has been told to prepare
    bool IsGrowing = false;   ///< whether it waits for more of a file to be indexed
    bool HasGrown = false;    ///< whether it did, since it was shown
    bool IsLarge = false;     ///< whether the next surface is drawn in portions
    QElapsedTimer Ready = {}; ///< since the next surface waits to be shown
  };

  void ObserveTimeButtons(QMainWindow* window);
  /// Whether changes by hand may give coarse surfaces: there is a window, and its user has not
  /// switched it off.
  bool IsCoarseFirst() const;
  void AllowCoarse(bool allowed);
  /// Until a surface is exact, too large, or cannot be made.
  void FinishOne(pqPipelineSource* source);
  /// True if a finer surface is to be shown; `keep`: whether the contour is to be watched further.
  bool AdvanceOne(Watched& watched, bool& keep);
  /// Whether to let a surface wait: while it is drawn for the first time, the window does not
  /// answer, and a hand that moves is about to do something.
  bool IsHandMoving(Watched& watched, const isosurface::Refinement& report) const;
  /// Has views show all of a surface that has grown with its index.
  void FrameGrown(pqPipelineSource* source);
  void AskAboutSize(pqPipelineSource* source, const isosurface::Refinement& report);
  void UseLevel(pqPipelineSource* source, int level);

  pqTimer* Timer;            ///< owned by this object; ParaView's test player waits for such timers
  pqSurfaceDrawing* Drawing; ///< owned by this object
  QPointer<pqRefinementStatus> Status; ///< belongs to the window; null without one
  QPointer<pqIndexStatus> Indices;     ///< the same
  QPointer<QDialog> Question;          ///< about a surface that is too large
  std::vector<Watched> All;
  std::map<vtkTypeUInt32, vtkBoundingBox> BoundsBefore; ///< of those that grow, by the proxies' ids
  bool Finishing = false;
  bool ChangingTime = false;
};

#endif
