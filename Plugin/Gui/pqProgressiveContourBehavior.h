// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqProgressiveContourBehavior
 * @brief   refines progressive contours while the user is idle
 *
 * Calls Refine of every Stabbing Contour with Progressive on whose surface is not final, then renders
 * all views. Does so when nothing was updated for RestMilliseconds, no mouse button is down and no
 * server is working. Refines one level at a time, so that the user can act between them.
 *
 * ParaView makes one object when its window loads the plugin.
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

  pqTimer* Timer; ///< owned by this object; ParaView's test player waits for such timers
};

#endif
