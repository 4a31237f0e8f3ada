// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSurfaceDrawing
 * @brief   draws views with large surfaces in portions, between which the window answers
 *
 * By software, millions of triangles take seconds to draw. Where this process draws, a view keeps its
 * image meanwhile: portions of the next one are drawn beside it (vtkIsosurfaceMapper::BeginBudget), and
 * it is shown when it is whole. So it is with a surface that was refined, and with the image after the
 * camera was turned by hand, which sees thinned surfaces until then.
 */

#ifndef pqSurfaceDrawing_h
#define pqSurfaceDrawing_h

#include "vtkNew.h"

#include <QElapsedTimer>
#include <QList>
#include <QObject>
#include <QPointer>

class pqTimer;
class pqView;
class vtkEventQtSlotConnect;
class vtkObject;

class pqSurfaceDrawing : public QObject
{
  Q_OBJECT
  typedef QObject Superclass;

public:
  explicit pqSurfaceDrawing(QObject* parent = nullptr);

  /// What the window is held for while a hand moves and while it rests. Each portion costs some 0.03 s
  /// beside it.
  static constexpr double MovingPortionSeconds = 0.12;
  static constexpr double RestingPortionSeconds = 0.3;
  /// A hand counts as moving until this time after its last event.
  static constexpr int MovingMilliseconds = 300;
  /// After a portion or an update, for the events of a moving hand.
  static constexpr int PauseMilliseconds = 20;
  /// A hand at the wheel turns it again within this time.
  static constexpr int RestMilliseconds = 150;
  /// While a mouse button is down.
  static constexpr int PollMilliseconds = 10;
  /// A view that changes in each portion is drawn at once after this number of portions.
  static constexpr int MostPortions = 300;

  /// Draws all views: those of this process in portions, others at once.
  void Begin();
  bool IsDrawing() const { return !this->Views.empty(); }
  /// Leaves the views as they are.
  void Stop();

  /// Whether the hand did something within a time.
  bool IsHandMoving(int milliseconds = MovingMilliseconds) const;

  /// Notices mouse, wheel and keys; filters no event.
  bool eventFilter(QObject* receiver, QEvent* event) override;

private Q_SLOTS:
  void Observe(pqView* view);
  /// A view has what turns its camera once it shows something.
  void ObserveCamera();
  /// The hand lets go of the camera, or turns the wheel: ParaView would draw the image between these.
  void HoldImage(vtkObject* interactor, unsigned long event);
  void DrawHeldImage(vtkObject* interactor, unsigned long event);
  void Advance();
  /// A view that another rendering has drawn as a whole is done.
  void Forget();

private:
  /// Draws a view in portions, after `milliseconds`, if this process draws it; false otherwise.
  bool Add(pqView* view, int milliseconds = 0);
  /// Draws a portion; whether the image is whole, and shown.
  bool DrawPortion(pqView* view);

  pqTimer* Timer; ///< owned by this object
  vtkNew<vtkEventQtSlotConnect> Connections;
  QElapsedTimer SinceHand;  ///< since its last event
  bool IsTurning = false;   ///< whether the hand holds a camera
  QPointer<pqView> Held;    ///< is not drawn at once, if
  bool IsImageHeld = false; ///< ParaView wanted to
  QList<QPointer<pqView>> Views;
  int Portions = 0; ///< of the first view
  bool IsInPortion = false;
};

#endif
