// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSurfaceDrawing
 * @brief   draws views with large surfaces in portions, between which the window answers
 *
 * By software, millions of triangles take seconds to draw. Where this process draws, a view keeps its
 * image meanwhile: portions of the next one are drawn beside it (vtkIsosurfaceMapper::BeginBudget), a
 * timer between them, and it is shown when it is whole. A hand that turns the camera sees each of its
 * images at once; the portions begin anew when the button is released.
 */

#ifndef pqSurfaceDrawing_h
#define pqSurfaceDrawing_h

#include <QList>
#include <QObject>
#include <QPointer>

class pqTimer;
class pqView;

class pqSurfaceDrawing : public QObject
{
  Q_OBJECT
  typedef QObject Superclass;

public:
  explicit pqSurfaceDrawing(QObject* parent = nullptr);
  ~pqSurfaceDrawing() override;

  /// What the window is held for. Each portion costs some 0.03 s beside it.
  static constexpr double PortionSeconds = 0.18;
  /// While a mouse button is down.
  static constexpr int PollMilliseconds = 10;
  /// A view that changes in each portion is drawn at once after so many.
  static constexpr int MostPortions = 300;

  /// Draws all views: those of this process in portions, others at once.
  void Begin();
  bool IsDrawing() const { return !this->Views.empty(); }
  /// Leaves the views as they are.
  void Stop();

private Q_SLOTS:
  void Advance();
  /// A view that was drawn as a whole by somebody else is done.
  void Forget();

private:
  Q_DISABLE_COPY(pqSurfaceDrawing)

  /// Draws a portion; whether the image is whole, and shown.
  bool DrawPortion(pqView* view);

  pqTimer* Timer; ///< owned by this object
  QList<QPointer<pqView>> Views;
  int Portions = 0; ///< of the first view
  bool IsInPortion = false;
};

#endif
