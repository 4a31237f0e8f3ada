// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqProgressiveContourBehavior
 * @brief   goes on to finer levels of progressive contours when the hand rests
 *
 * Whenever a Stabbing Contour with Progressive on has given a surface that is not final, and then
 * nothing was updated for RestMilliseconds, no mouse button is down and no server is at work, this
 * calls its Refine and lets all views render: one level at a time, so that the user is heard
 * between them.
 *
 * ParaView makes the one object when the plugin is loaded into its window.
 */

#ifndef pqProgressiveContourBehavior_h
#define pqProgressiveContourBehavior_h

#include <QObject>

class pqPipelineSource;
class pqTimer;

class pqProgressiveContourBehavior : public QObject
{
  Q_OBJECT

public:
  explicit pqProgressiveContourBehavior(QObject* parent = nullptr);
  ~pqProgressiveContourBehavior() override;

  static constexpr int RestMilliseconds = 300;

  void OnStartup();
  void OnShutdown();

private Q_SLOTS:
  void Observe(pqPipelineSource* source);
  void WaitForRest(pqPipelineSource* source);
  void Refine();

private:
  Q_DISABLE_COPY(pqProgressiveContourBehavior)

  pqTimer* Timer; ///< one that ParaView's test player waits for; belongs to this
};

#endif
