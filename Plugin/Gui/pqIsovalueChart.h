// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqIsovalueChart
 * @brief   chooses isovalues by handles on a contour spectrum
 *
 * Draws a quantity of the spectrum over the isovalue, the histogram of the values behind it, and a
 * vertical handle for each isovalue. What an isosurface will be and cost stands beside the handle
 * that is dragged or selected, or beside the mouse: the readout.
 *
 * - Drag a handle to move it; double-click to add one; Delete removes the selected one.
 * - Left, Right: a fine step; with Shift ten of them. Page Up, Page Down: the next handle.
 * - Wheel: zoom of the value axis around the mouse; Home shows all. Shift and wheel, or dragging
 *   with the middle button, moves the visible range.
 *
 * Knows nothing of ParaView. The listener to isovaluesChanged owns the isovalues; they keep their
 * order.
 */

#ifndef pqIsovalueChart_h
#define pqIsovalueChart_h

#include "SpectrumPlot.h"
#include "ValueAxis.h"

#include <QColor>
#include <QVariantList>
#include <QVector>
#include <QWidget>

#include <functional>

class pqIsovalueChart : public QWidget
{
  Q_OBJECT
  /// The isovalues, by the name that pqScalarValueListPropertyWidget has for its own.
  Q_PROPERTY(QVariantList scalars READ GetIsovalues WRITE SetIsovalues NOTIFY isovaluesChanged)
  /// The same in one line, for tests.
  Q_PROPERTY(QString isovalueText READ GetIsovalueText)
  Q_PROPERTY(QString rangeText READ GetRangeText)
  Q_PROPERTY(QString readout READ GetReadout)
  Q_PROPERTY(QString note READ GetNote)
  Q_PROPERTY(int selected READ GetSelected WRITE Select)
  Q_PROPERTY(bool zoomed READ IsZoomed)
  Q_PROPERTY(bool hasSpectrum READ HasSpectrum)

public:
  using Quantity = isosurface::SpectrumCurve::Quantity;
  /// The predicted duration of an extraction in words; empty if it is not known.
  using DurationWords = std::function<QString(const isosurface::IsosurfaceForecast&)>;

  explicit pqIsovalueChart(QWidget* parent = nullptr);

  ///@{
  /// The spectrum that is drawn; none: an empty chart with a message in it.
  void SetSpectrum(const isosurface::SpectrumCurve& spectrum);
  void SetMessage(const QString& message);
  const isosurface::SpectrumCurve& GetSpectrum() const { return this->Plot.GetSpectrum(); }
  bool HasSpectrum() const { return !this->GetSpectrum().IsEmpty(); }
  ///@}

  /// The values of the axis where there is no spectrum.
  void SetRange(double minimum, double maximum);

  /// The quantity that is drawn: Triangles, ActiveBlocks, Bytes or Area.
  void SetQuantity(Quantity quantity);

  void SetDurationWords(DurationWords words);

  /// Whether blocks and bytes are read from files; else they lie in memory.
  void SetStored(bool stored);

  /// The share of the volume that the spectrum is of; less than 1 is told in a note.
  void SetShare(double share);
  QString GetNote() const;

  /// One color for each isovalue; none: a color of the style.
  void SetColors(const QVector<QColor>& colors);

  QVariantList GetIsovalues() const;
  void SetIsovalues(const QVariantList& isovalues);
  /// As by hand.
  void ChangeIsovalues(const QVariantList& isovalues);
  QString GetIsovalueText() const;
  QString GetRangeText() const; ///< of the values that are visible

  int GetSelected() const { return this->Selected; }
  void Select(int handle);
  bool IsDragging() const { return this->Dragged >= 0; }
  bool IsZoomed() const { return this->Axis.IsZoomed(); }
  const isosurface::ValueAxis& GetAxis() const { return this->Axis; }

  /// What stands beside the handle or the mouse, its lines joined; empty if nothing does.
  QString GetReadout() const;

  /// The handle at a place of the widget; -1 if there is none.
  int FindHandle(const QPoint& place) const;

  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;

Q_SIGNALS:
  /// A hand changed them.
  void isovaluesChanged();
  void dragStarted();
  void dragFinished();

public Q_SLOTS:
  void ShowAll();
  void EndDrag();

protected:
  bool event(QEvent* event) override;
  void paintEvent(QPaintEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void leaveEvent(QEvent* event) override;

private:
  QRect GetPlot() const;
  void MoveTo(int handle, double isovalue);
  void Remove(int handle);
  QColor GetColor(int handle) const;
  QStringList DescribeIsovalue(double isovalue) const;
  /// Finds the isovalue whose readout is shown; false if there is none.
  bool FindReadoutIsovalue(double& isovalue) const;

  void PaintHandle(QPainter& painter, int handle) const;
  void PaintReadout(QPainter& painter) const;

  isosurface::SpectrumPlot Plot;
  QString Message;
  isosurface::ValueAxis Axis;
  DurationWords Words;
  bool Stored = false;
  double Share = 1;

  QVector<double> Isovalues;
  QVector<QColor> Colors;
  int Selected = -1;
  int Dragged = -1;
  double GrabOffset = 0; ///< from the mouse to the dragged handle, in pixels
  int PanFrom = 0;
  bool Panning = false;
  QPoint Hover;
  bool Hovering = false;
};

#endif
