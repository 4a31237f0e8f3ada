// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqIndexStatus
 * @brief   files that are opened by hand are shown at once, and exactly when they are indexed
 *
 * A button in the status bar, visible while a Volume Reader (Any Size) shows a sample of a file and
 * the index is written beside the window: how far it is, how long it still takes, and a menu that
 * stops it. A timer lets the servers work and asks how far they are (AdvanceIndex), and tells them what
 * the active view shows (LookAlong). At the end the reader takes the index, and `indexed` tells that views are to be updated.
 */

#ifndef pqIndexStatus_h
#define pqIndexStatus_h

#include "vtkType.h"

#include <QElapsedTimer>
#include <QPointer>
#include <QToolButton>

#include <map>
#include <vector>

class pqPipelineSource;
class pqTimer;
class vtkBoundingBox;
class vtkSMProxy;

class pqIndexStatus : public QToolButton
{
  Q_OBJECT
  typedef QToolButton Superclass;

public:
  explicit pqIndexStatus(QWidget* parent = nullptr);

  /// Between two questions how far an index is.
  static constexpr int PollMilliseconds = 100;
  /// The same where several ranks write an index, which they do only while they are asked.
  static constexpr int PollRanksMilliseconds = 5;
  /// A view rests if it has shown the same for so long.
  static constexpr int RestMilliseconds = 300;
  /// How long these write before they answer.
  static constexpr int SliceMilliseconds = 60;

  static bool IsReader(vtkSMProxy* proxy);
  static vtkBoundingBox FindBounds(pqPipelineSource* source);
  /// Has views show all of a source that has become much larger than its bounds `before`.
  static void FrameIfLarger(pqPipelineSource* source, const vtkBoundingBox& before);

  /// Waits until no index is written any more, before something is saved.
  void Finish();

public Q_SLOTS:
  /// Watches a reader that has executed; other sources are left alone.
  void Watch(pqPipelineSource* source);

Q_SIGNALS:
  void indexed();

private Q_SLOTS:
  void Advance();
  void Stop();

private:
  using Sources = std::vector<QPointer<pqPipelineSource>>;

  /// Whether the index is to be watched further. Readers that have taken something new are added.
  bool AdvanceOne(pqPipelineSource* source, Sources& changed);
  /// What the active view shows, once the hand has left it as it is for a while; empty before that.
  std::vector<double> FindSight();
  /// Has views updated, and shows all of a volume of which a part was shown before.
  void Update(const Sources& changed);

  pqTimer* Timer;           ///< ParaView's test player waits for such timers
  Sources Readers;          ///< whose index is being written
  std::vector<double> Seen; ///< what the active view shows
  QElapsedTimer SinceSeen;  ///< since it has shown something else
  std::map<vtkTypeUInt32, std::vector<double>> Told; ///< to readers, by their global ids
};

#endif
