// SPDX-License-Identifier: BSD-3-Clause
#include "pqIsovalueChart.h"

#include "CountWords.h"

#include <QEvent>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QPainterPath>
#include <QWheelEvent>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

using isosurface::IsosurfaceForecast;
using isosurface::SpectrumCurve;

namespace
{

constexpr int GripHeight = 11; ///< of the triangle atop a handle
constexpr int GripWidth = 12;
constexpr int SideMargin = 8;
constexpr int GrabDistance = 6; ///< pixels beside a handle that still belong to it
constexpr double WheelFactor = 1.25;
constexpr int WheelNotch = 120; ///< Qt's unit: eighths of a degree
constexpr int TickSpacing = 60;
constexpr int ReadoutMargin = 4;

/// Of the spectrum: legible on light and dark grounds.
const QColor CurveColor(52, 120, 190);

/// Digits that tell two doubles of an axis apart, and no more.
QString FormatValue(double value)
{
  return QString::number(value, 'g', 7);
}

} // namespace

//------------------------------------------------------------------------------
pqIsovalueChart::pqIsovalueChart(QWidget* parent)
  : QWidget(parent)
{
  this->setFocusPolicy(Qt::StrongFocus);
  this->setMouseTracking(true);
  this->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  this->setAccessibleName(tr("Isovalues on the contour spectrum"));
  this->LayOut();
}

//------------------------------------------------------------------------------
pqIsovalueChart::~pqIsovalueChart() = default;

//------------------------------------------------------------------------------
QSize pqIsovalueChart::sizeHint() const
{
  return QSize(300, 9 * this->fontMetrics().height());
}

//------------------------------------------------------------------------------
QSize pqIsovalueChart::minimumSizeHint() const
{
  return QSize(120, 7 * this->fontMetrics().height());
}

//------------------------------------------------------------------------------
void pqIsovalueChart::SetSpectrum(const SpectrumCurve& spectrum)
{
  this->Spectrum = spectrum;
  this->Histogram = spectrum.MakeHistogram();
  if (!spectrum.IsEmpty())
  {
    this->Message.clear();
    this->Axis.SetRange(
      spectrum.GetIsovalues().front(), spectrum.GetIsovalues().back(), spectrum.HasIntegers());
  }
  this->SetQuantity(this->Drawn);
}

//------------------------------------------------------------------------------
void pqIsovalueChart::SetMessage(const QString& message)
{
  this->Message = message;
  this->update();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::SetRange(double minimum, double maximum)
{
  if (this->Spectrum.IsEmpty())
  {
    this->Axis.SetRange(minimum, maximum, this->Spectrum.HasIntegers());
    this->update();
  }
}

//------------------------------------------------------------------------------
void pqIsovalueChart::SetQuantity(Quantity quantity)
{
  this->Drawn = quantity;
  this->Logarithmic = this->Spectrum.SpansDecades(quantity);
  this->Least = std::numeric_limits<double>::infinity();
  this->Largest = 0;
  for (const double value : this->Spectrum.Get(quantity))
  {
    this->Least = value > 0 ? std::min(this->Least, value) : this->Least;
    this->Largest = std::max(this->Largest, value);
  }
  this->update();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::SetDurationWords(DurationWords words)
{
  this->Words = std::move(words);
  this->update();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::SetStored(bool stored)
{
  this->Stored = stored;
  this->update();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::SetColors(const QVector<QColor>& colors)
{
  this->Colors = colors;
  this->update();
}

//------------------------------------------------------------------------------
QColor pqIsovalueChart::GetColor(int handle) const
{
  return handle < this->Colors.size() ? this->Colors[handle] : this->palette().highlight().color();
}

//------------------------------------------------------------------------------
QVariantList pqIsovalueChart::GetIsovalues() const
{
  QVariantList values;
  for (const double value : this->Isovalues)
  {
    values.push_back(value);
  }
  return values;
}

//------------------------------------------------------------------------------
void pqIsovalueChart::SetIsovalues(const QVariantList& isovalues)
{
  QVector<double> values;
  for (const QVariant& value : isovalues)
  {
    values.push_back(value.toDouble());
  }
  if (values == this->Isovalues)
  {
    return;
  }
  this->Isovalues = values;
  this->Selected = std::min(this->Selected, this->Isovalues.size() - 1);
  if (this->Dragged >= this->Isovalues.size())
  {
    this->EndDrag();
  }
  this->update();
}

//------------------------------------------------------------------------------
QString pqIsovalueChart::GetIsovalueText() const
{
  QStringList words;
  for (const double value : this->Isovalues)
  {
    words.push_back(FormatValue(value));
  }
  return words.join(' ');
}

//------------------------------------------------------------------------------
QString pqIsovalueChart::GetRangeText() const
{
  return FormatValue(this->Axis.GetMinimum()) + " " + FormatValue(this->Axis.GetMaximum());
}

//------------------------------------------------------------------------------
void pqIsovalueChart::Select(int handle)
{
  this->Selected = std::clamp(handle, -1, this->Isovalues.size() - 1);
  if (this->Selected >= 0)
  {
    this->Axis.Show(this->Isovalues[this->Selected]);
  }
  this->update();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::ShowAll()
{
  this->Axis.ShowAll();
  this->update();
}

//------------------------------------------------------------------------------
QRect pqIsovalueChart::GetPlot() const
{
  const int axis = this->fontMetrics().height() + 4;
  return this->rect().adjusted(SideMargin, GripHeight + 1, -SideMargin, -axis);
}

//------------------------------------------------------------------------------
void pqIsovalueChart::LayOut()
{
  const QRect plot = this->GetPlot();
  this->Axis.SetPixels(plot.left(), plot.width() - 1);
}

//------------------------------------------------------------------------------
int pqIsovalueChart::FindHandle(const QPoint& place) const
{
  int found = -1;
  double nearest = GrabDistance + 0.5;
  for (int handle = 0; handle < this->Isovalues.size(); ++handle)
  {
    const double distance = std::abs(this->Axis.ToPixel(this->Isovalues[handle]) - place.x());
    // Of handles at one place the selected one lies on top.
    if (distance < nearest || (distance == nearest && handle == this->Selected))
    {
      found = handle;
      nearest = distance;
    }
  }
  return found;
}

//------------------------------------------------------------------------------
void pqIsovalueChart::MoveTo(int handle, double isovalue)
{
  if (isovalue != this->Isovalues[handle])
  {
    this->Isovalues[handle] = isovalue;
    this->update();
    Q_EMIT this->isovaluesChanged();
  }
}

//------------------------------------------------------------------------------
void pqIsovalueChart::Remove(int handle)
{
  this->EndDrag();
  this->Isovalues.remove(handle);
  this->Selected = std::min(handle, this->Isovalues.size() - 1);
  this->update();
  Q_EMIT this->isovaluesChanged();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::EndDrag()
{
  if (this->Dragged >= 0)
  {
    this->Dragged = -1;
    this->update();
    Q_EMIT this->dragFinished();
  }
}

//------------------------------------------------------------------------------
bool pqIsovalueChart::event(QEvent* event)
{
  // The window has shortcuts of these keys: Delete deletes the filter.
  if (event->type() == QEvent::ShortcutOverride && this->Selected >= 0)
  {
    switch (static_cast<QKeyEvent*>(event)->key())
    {
      case Qt::Key_Delete:
      case Qt::Key_Backspace:
      case Qt::Key_Left:
      case Qt::Key_Right:
        event->accept();
        return true;
      default:
        break;
    }
  }
  return QWidget::event(event);
}

//------------------------------------------------------------------------------
void pqIsovalueChart::resizeEvent(QResizeEvent* event)
{
  QWidget::resizeEvent(event);
  this->LayOut();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::mousePressEvent(QMouseEvent* event)
{
  if (event->button() == Qt::MiddleButton)
  {
    this->Panning = true;
    this->PanFrom = event->x();
    return;
  }
  if (event->button() != Qt::LeftButton)
  {
    QWidget::mousePressEvent(event);
    return;
  }
  this->EndDrag();
  this->Selected = this->FindHandle(event->pos());
  if (this->Selected >= 0)
  {
    this->Dragged = this->Selected;
    this->GrabOffset = this->Axis.ToPixel(this->Isovalues[this->Dragged]) - event->x();
    Q_EMIT this->dragStarted();
  }
  this->update();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::mouseMoveEvent(QMouseEvent* event)
{
  this->Hover = event->pos();
  this->Hovering = true;
  if (this->Panning)
  {
    this->Axis.Pan(this->PanFrom, event->x());
    this->PanFrom = event->x();
  }
  // While a server is at work ParaView swallows mouse events, the release of the button too.
  if (this->Dragged >= 0 && !(event->buttons() & Qt::LeftButton))
  {
    this->EndDrag();
  }
  if (this->Dragged >= 0)
  {
    const double value = this->Axis.ToValue(event->x() + this->GrabOffset);
    this->MoveTo(this->Dragged, this->Axis.Snap(value));
  }
  this->setCursor(this->FindHandle(event->pos()) >= 0 ? Qt::SizeHorCursor : Qt::ArrowCursor);
  this->update();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::mouseReleaseEvent(QMouseEvent* event)
{
  this->Panning = this->Panning && event->button() != Qt::MiddleButton;
  if (event->button() == Qt::LeftButton)
  {
    this->EndDrag();
  }
}

//------------------------------------------------------------------------------
void pqIsovalueChart::mouseDoubleClickEvent(QMouseEvent* event)
{
  if (event->button() != Qt::LeftButton || this->FindHandle(event->pos()) >= 0)
  {
    return;
  }
  this->Isovalues.push_back(this->Axis.Snap(this->Axis.ToValue(event->x())));
  this->Selected = this->Isovalues.size() - 1;
  this->update();
  Q_EMIT this->isovaluesChanged();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::wheelEvent(QWheelEvent* event)
{
  const double notches = static_cast<double>(event->angleDelta().y()) / WheelNotch;
  const double place = event->position().x();
  if (event->modifiers() & Qt::ShiftModifier)
  {
    this->Axis.Pan(place, place + notches * this->GetPlot().width() / 10);
  }
  else
  {
    this->Axis.Zoom(place, std::pow(WheelFactor, notches));
  }
  event->accept();
  this->update();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::keyPressEvent(QKeyEvent* event)
{
  const int handles = this->Isovalues.size();
  const double step = this->Axis.GetStep() * (event->modifiers() & Qt::ShiftModifier ? 10 : 1);
  const bool selected = this->Selected >= 0;
  const int key = event->key();
  if (key == Qt::Key_Home)
  {
    this->ShowAll();
  }
  else if ((key == Qt::Key_PageUp || key == Qt::Key_PageDown) && handles > 0)
  {
    const int change = key == Qt::Key_PageDown ? 1 : handles - 1;
    this->Select(selected ? (this->Selected + change) % handles : 0);
  }
  else if ((key == Qt::Key_Left || key == Qt::Key_Right) && selected)
  {
    const double change = key == Qt::Key_Right ? step : -step;
    this->MoveTo(this->Selected, this->Axis.Snap(this->Isovalues[this->Selected] + change));
    this->Axis.Show(this->Isovalues[this->Selected]);
  }
  else if ((key == Qt::Key_Delete || key == Qt::Key_Backspace) && selected)
  {
    this->Remove(this->Selected);
  }
  else
  {
    QWidget::keyPressEvent(event);
  }
}

//------------------------------------------------------------------------------
void pqIsovalueChart::leaveEvent(QEvent* event)
{
  this->Hovering = false;
  this->update();
  QWidget::leaveEvent(event);
}

//------------------------------------------------------------------------------
QStringList pqIsovalueChart::DescribeIsovalue(double isovalue) const
{
  QStringList lines = { FormatValue(isovalue) };
  if (this->Spectrum.IsEmpty())
  {
    return lines;
  }
  const IsosurfaceForecast forecast = this->Spectrum.Forecast(isovalue);
  lines.push_back(tr("%1 triangles").arg(isosurface::FormatCount(forecast.Triangles)));
  if (this->Spectrum.Knows(Quantity::ActiveBlocks))
  {
    lines.push_back((this->Stored ? tr("%1 blocks, %2 to read") : tr("%1 blocks, %2"))
                      .arg(isosurface::FormatCount(forecast.Blocks))
                      .arg(isosurface::FormatBytes(forecast.Bytes)));
  }
  const QString duration = this->Words ? this->Words(forecast) : QString();
  if (!duration.isEmpty())
  {
    lines.push_back(duration);
  }
  return lines;
}

//------------------------------------------------------------------------------
bool pqIsovalueChart::FindReadoutIsovalue(double& isovalue) const
{
  const int handle = this->Dragged >= 0 ? this->Dragged
    : this->Hovering                    ? this->FindHandle(this->Hover)
                                        : this->Selected;
  if (handle >= 0)
  {
    isovalue = this->Isovalues[handle];
    return true;
  }
  if (this->Hovering && !this->Spectrum.IsEmpty() && this->GetPlot().contains(this->Hover))
  {
    isovalue = this->Axis.Snap(this->Axis.ToValue(this->Hover.x()));
    return true;
  }
  return false;
}

//------------------------------------------------------------------------------
QString pqIsovalueChart::GetReadout() const
{
  double isovalue = 0;
  return this->FindReadoutIsovalue(isovalue) ? this->DescribeIsovalue(isovalue).join("; ")
                                             : QString();
}

//------------------------------------------------------------------------------
double pqIsovalueChart::GetHeight(double value) const
{
  if (!(value > 0))
  {
    return 0;
  }
  if (!this->Logarithmic)
  {
    return value / this->Largest;
  }
  // The least value is a little above the bottom, where 0 is.
  const double decades = std::log10(this->Largest / this->Least);
  return 0.06 + 0.94 * std::log10(value / this->Least) / decades;
}

//------------------------------------------------------------------------------
void pqIsovalueChart::paintEvent(QPaintEvent*)
{
  QPainter painter(this);
  const QRect plot = this->GetPlot();
  painter.fillRect(plot, this->palette().base());
  this->PaintSpectrum(painter);
  this->PaintAxes(painter);
  if (!this->Message.isEmpty())
  {
    painter.setPen(this->palette().text().color());
    painter.drawText(plot, Qt::AlignCenter | Qt::TextWordWrap, this->Message);
  }
  for (int handle = 0; handle < this->Isovalues.size(); ++handle)
  {
    if (handle != this->Selected)
    {
      this->PaintHandle(painter, handle);
    }
  }
  if (this->Selected >= 0)
  {
    this->PaintHandle(painter, this->Selected);
  }
  this->PaintReadout(painter);
  if (this->hasFocus())
  {
    painter.setBrush(Qt::NoBrush);
    painter.setPen(this->palette().highlight().color());
    painter.drawRect(plot.adjusted(-1, -1, 0, 0));
  }
}

//------------------------------------------------------------------------------
void pqIsovalueChart::PaintSpectrum(QPainter& painter) const
{
  if (this->Spectrum.IsEmpty())
  {
    return;
  }
  const QRect plot = this->GetPlot();
  const std::vector<double>& isovalues = this->Spectrum.GetIsovalues();
  const std::vector<double>& values = this->Spectrum.Get(this->Drawn);
  const QColor text = this->palette().text().color();
  const double top = plot.top() + 2;
  const double bottom = plot.bottom() + 1;
  painter.save();
  painter.setClipRect(plot);

  // The histogram by columns of pixels, on a logarithmic scale: peaks hide all else on a linear one.
  std::vector<double> columns(static_cast<std::size_t>(plot.width()), 0.0);
  for (std::size_t bin = 0; bin < this->Histogram.size(); ++bin)
  {
    const double from = this->Axis.ToPixel(isovalues[bin]) - plot.left();
    const double to = this->Axis.ToPixel(isovalues[bin + 1]) - plot.left();
    const int first = static_cast<int>(std::clamp(from, 0.0, 1.0 * plot.width()));
    const int last = static_cast<int>(std::clamp(std::ceil(to), 0.0, 1.0 * plot.width()));
    for (int column = first; column < last; ++column)
    {
      double& height = columns[static_cast<std::size_t>(column)];
      height = std::max(height, this->Histogram[bin]);
    }
  }
  const double highest = columns.empty() ? 0 : *std::max_element(columns.begin(), columns.end());
  QColor grey = text;
  grey.setAlpha(45);
  for (int column = 0; column < plot.width() && highest > 0; ++column)
  {
    // Five decades below the highest peak.
    const double share = columns[static_cast<std::size_t>(column)] / highest;
    const double height = share > 0 ? std::max(0.0, 1 + std::log10(share) / 5) : 0;
    const int pixels = static_cast<int>(height * (bottom - top) * 0.9);
    painter.fillRect(plot.left() + column, plot.bottom() + 1 - pixels, 1, pixels, grey);
  }

  if (!values.empty())
  {
    QPainterPath curve;
    for (std::size_t index = 0; index < values.size(); ++index)
    {
      const QPointF point(this->Axis.ToPixel(isovalues[index]),
        bottom - this->GetHeight(values[index]) * (bottom - top));
      if (index == 0)
      {
        curve.moveTo(point);
      }
      else
      {
        curve.lineTo(point);
      }
    }
    painter.setRenderHint(QPainter::Antialiasing);
    QColor line = CurveColor;
    painter.setPen(QPen(line, 1.8));
    painter.drawPath(curve);
    curve.lineTo(this->Axis.ToPixel(isovalues.back()), bottom);
    curve.lineTo(this->Axis.ToPixel(isovalues.front()), bottom);
    line.setAlpha(30);
    painter.fillPath(curve, line);
  }
  painter.restore();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::PaintAxes(QPainter& painter) const
{
  const QRect plot = this->GetPlot();
  const QFontMetrics metrics = this->fontMetrics();
  QColor faint = this->palette().windowText().color();
  painter.setPen(faint);
  painter.drawLine(plot.bottomLeft() + QPoint(0, 1), plot.bottomRight() + QPoint(0, 1));
  for (const double tick : this->Axis.MakeTicks(TickSpacing))
  {
    const int x = static_cast<int>(std::lround(this->Axis.ToPixel(tick)));
    const QString label = FormatValue(tick);
    const int width = metrics.horizontalAdvance(label);
    const int left = std::clamp(x - width / 2, 0, std::max(0, this->width() - width));
    painter.drawLine(x, plot.bottom() + 1, x, plot.bottom() + 4);
    painter.drawText(left, plot.bottom() + 4 + metrics.ascent(), label);
  }
  if (this->Spectrum.Get(this->Drawn).empty() || !(this->Largest > 0))
  {
    return;
  }
  // The quantity's own scale: the maximum, and decades below it.
  faint.setAlpha(110);
  painter.setPen(faint);
  const double span = plot.height() - 2;
  int lastLabel = std::numeric_limits<int>::max();
  const auto label = [&](double value)
  {
    const int y = static_cast<int>(std::lround(plot.bottom() + 1 - this->GetHeight(value) * span));
    painter.drawLine(plot.left(), y, plot.left() + 4, y);
    if (std::abs(lastLabel - y) > metrics.height() && y - plot.top() < plot.height() - 4)
    {
      const int baseline = std::max(plot.top() + metrics.ascent(), y + metrics.ascent() / 2);
      painter.drawText(plot.left() + 6, baseline, isosurface::FormatCount(value));
      lastLabel = y;
    }
  };
  label(this->Largest);
  if (this->Logarithmic)
  {
    for (double decade = std::pow(10.0, std::floor(std::log10(this->Largest)));
         decade >= this->Least; decade /= 10)
    {
      label(decade);
    }
  }
}

//------------------------------------------------------------------------------
void pqIsovalueChart::PaintHandle(QPainter& painter, int handle) const
{
  const QRect plot = this->GetPlot();
  const double exact = this->Axis.ToPixel(this->Isovalues[handle]);
  // One that is out of sight leaves its grip at the side where it is.
  const bool visible = exact >= plot.left() - 0.5 && exact <= plot.right() + 0.5;
  const double x = std::clamp(exact, 1.0 * plot.left(), 1.0 * plot.right());
  const QColor color = this->GetColor(handle);
  const QColor outline = this->palette().windowText().color();
  painter.save();
  painter.setRenderHint(QPainter::Antialiasing);
  if (visible)
  {
    const double width = handle == this->Selected ? 2.5 : 1.5;
    QColor shadow = outline;
    shadow.setAlpha(120);
    painter.setPen(QPen(shadow, width + 1.5));
    painter.drawLine(QPointF(x, GripHeight), QPointF(x, plot.bottom() + 1));
    painter.setPen(QPen(color, width));
    painter.drawLine(QPointF(x, GripHeight), QPointF(x, plot.bottom() + 1));
  }
  QPolygonF grip;
  grip << QPointF(x - GripWidth / 2.0, 1) << QPointF(x + GripWidth / 2.0, 1)
       << QPointF(x, GripHeight + 1);
  if (!visible)
  {
    const double back = exact < plot.left() ? GripHeight : -GripHeight;
    grip = QPolygonF();
    grip << QPointF(x, GripHeight / 2.0 + 1) << QPointF(x + back, 1)
         << QPointF(x + back, GripHeight + 1);
  }
  painter.setPen(QPen(outline, handle == this->Selected ? 1.6 : 0.8));
  painter.setBrush(color);
  painter.drawPolygon(grip);
  painter.restore();
}

//------------------------------------------------------------------------------
void pqIsovalueChart::PaintReadout(QPainter& painter) const
{
  double isovalue = 0;
  if (!this->FindReadoutIsovalue(isovalue))
  {
    return;
  }
  const QStringList lines = this->DescribeIsovalue(isovalue);
  const QFontMetrics metrics = this->fontMetrics();
  int width = 0;
  for (const QString& line : lines)
  {
    width = std::max(width, metrics.horizontalAdvance(line));
  }
  const QRect plot = this->GetPlot();
  const int x = static_cast<int>(std::lround(this->Axis.ToPixel(isovalue)));
  QRect box(
    0, plot.top() + 2, width + 2 * ReadoutMargin, lines.size() * metrics.height() + ReadoutMargin);
  // On the side of the handle that has room.
  box.moveLeft(x + 8 + box.width() <= plot.right() ? x + 8 : std::max(0, x - 8 - box.width()));
  if (this->Hovering && this->Dragged < 0 && this->FindHandle(this->Hover) < 0)
  {
    painter.setPen(QPen(this->palette().windowText().color(), 1, Qt::DotLine));
    painter.drawLine(x, plot.top(), x, plot.bottom());
  }
  QColor ground = this->palette().toolTipBase().color();
  ground.setAlpha(230);
  painter.setPen(this->palette().toolTipText().color());
  painter.setBrush(ground);
  painter.drawRect(box);
  for (int line = 0; line < lines.size(); ++line)
  {
    painter.drawText(box.left() + ReadoutMargin,
      box.top() + ReadoutMargin / 2 + line * metrics.height() + metrics.ascent(), lines[line]);
  }
}
