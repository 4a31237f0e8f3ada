// SPDX-License-Identifier: BSD-3-Clause
#include "pqIsovalueChart.h"

#include "CountWords.h"

#include <QEvent>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QWheelEvent>

#include <algorithm>
#include <cmath>
#include <utility>

using isosurface::SpectrumCurve;

namespace
{

constexpr int SideMargin = 8;
constexpr int GrabDistance = 6; ///< pixels beside a handle that still belong to it
constexpr double WheelFactor = 1.25;
constexpr int WheelNotch = 120; ///< Qt's unit: eighths of a degree

} // namespace

pqIsovalueChart::pqIsovalueChart(QWidget* parent)
  : QWidget(parent)
{
  this->setFocusPolicy(Qt::StrongFocus);
  this->setMouseTracking(true);
  this->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  this->setAccessibleName(tr("Isovalues on the contour spectrum"));
}

QSize pqIsovalueChart::sizeHint() const
{
  return QSize(300, 9 * this->fontMetrics().height());
}

QSize pqIsovalueChart::minimumSizeHint() const
{
  return QSize(120, 7 * this->fontMetrics().height());
}

void pqIsovalueChart::SetSpectrum(const SpectrumCurve& spectrum)
{
  this->Plot.SetSpectrum(spectrum);
  if (!spectrum.IsEmpty())
  {
    this->Message.clear();
    this->Axis.SetRange(
      spectrum.GetIsovalues().front(), spectrum.GetIsovalues().back(), spectrum.HasIntegers());
  }
  this->update();
}

void pqIsovalueChart::SetMessage(const QString& message)
{
  this->Message = message;
  this->update();
}

void pqIsovalueChart::SetRange(double minimum, double maximum)
{
  if (this->GetSpectrum().IsEmpty())
  {
    this->Axis.SetRange(minimum, maximum, this->GetSpectrum().HasIntegers());
    this->update();
  }
}

void pqIsovalueChart::SetQuantity(Quantity quantity)
{
  this->Plot.SetQuantity(quantity);
  this->update();
}

void pqIsovalueChart::SetDurationWords(DurationWords words)
{
  this->Words = std::move(words);
  this->update();
}

void pqIsovalueChart::SetStored(bool stored)
{
  this->Stored = stored;
  this->update();
}

void pqIsovalueChart::SetShare(double share)
{
  this->Share = share;
  this->update();
}

QString pqIsovalueChart::GetNote() const
{
  return this->Share < 1 && this->HasSpectrum()
    ? tr("of %1 % of the volume").arg(std::ceil(100 * this->Share))
    : QString();
}

void pqIsovalueChart::SetColors(const QVector<QColor>& colors)
{
  this->Colors = colors;
  this->update();
}

QColor pqIsovalueChart::GetColor(int handle) const
{
  return handle < this->Colors.size() ? this->Colors[handle] : this->palette().highlight().color();
}

QVariantList pqIsovalueChart::GetIsovalues() const
{
  QVariantList values;
  for (const double value : this->Isovalues)
  {
    values.push_back(value);
  }
  return values;
}

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
  this->Selected = std::min(this->Selected, static_cast<int>(this->Isovalues.size()) - 1);
  if (this->Dragged >= this->Isovalues.size())
  {
    this->EndDrag();
  }
  this->update();
}

void pqIsovalueChart::ChangeIsovalues(const QVariantList& isovalues)
{
  this->SetIsovalues(isovalues);
  Q_EMIT this->isovaluesChanged();
}

QString pqIsovalueChart::GetIsovalueText() const
{
  QStringList words;
  for (const double value : this->Isovalues)
  {
    words.push_back(isosurface::FormatValue(value));
  }
  return words.join(' ');
}

QString pqIsovalueChart::GetRangeText() const
{
  return isosurface::FormatValue(this->Axis.GetMinimum()) + " " +
    isosurface::FormatValue(this->Axis.GetMaximum());
}

void pqIsovalueChart::Select(int handle)
{
  this->Selected = std::clamp(handle, -1, static_cast<int>(this->Isovalues.size()) - 1);
  if (this->Selected >= 0)
  {
    this->Axis.Show(this->Isovalues[this->Selected]);
  }
  this->update();
}

void pqIsovalueChart::ShowAll()
{
  this->Axis.ShowAll();
  this->update();
}

QRect pqIsovalueChart::GetPlot() const
{
  const int axis = this->fontMetrics().height() + 4;
  return this->rect().adjusted(SideMargin, isosurface::GripHeight + 1, -SideMargin, -axis);
}

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

void pqIsovalueChart::MoveTo(int handle, double isovalue)
{
  if (isovalue != this->Isovalues[handle])
  {
    this->Isovalues[handle] = isovalue;
    this->update();
    Q_EMIT this->isovaluesChanged();
  }
}

void pqIsovalueChart::Remove(int handle)
{
  this->EndDrag();
  this->Isovalues.remove(handle);
  this->Selected = std::min(handle, static_cast<int>(this->Isovalues.size()) - 1);
  this->update();
  Q_EMIT this->isovaluesChanged();
}

void pqIsovalueChart::EndDrag()
{
  if (this->Dragged >= 0)
  {
    this->Dragged = -1;
    this->update();
    Q_EMIT this->dragFinished();
  }
}

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

void pqIsovalueChart::resizeEvent(QResizeEvent* event)
{
  QWidget::resizeEvent(event);
  const QRect plot = this->GetPlot();
  this->Axis.SetPixels(plot.left(), plot.width() - 1);
}

void pqIsovalueChart::mousePressEvent(QMouseEvent* event)
{
  if (event->button() == Qt::MiddleButton)
  {
    this->Panning = true;
    this->PanFrom = event->pos().x();
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
    this->GrabOffset = this->Axis.ToPixel(this->Isovalues[this->Dragged]) - event->pos().x();
    Q_EMIT this->dragStarted();
  }
  this->update();
}

void pqIsovalueChart::mouseMoveEvent(QMouseEvent* event)
{
  this->Hover = event->pos();
  this->Hovering = true;
  if (this->Panning)
  {
    this->Axis.Pan(this->PanFrom, event->pos().x());
    this->PanFrom = event->pos().x();
  }
  // While a server is at work ParaView swallows mouse events, the release of the button too.
  if (this->Dragged >= 0 && !(event->buttons() & Qt::LeftButton))
  {
    this->EndDrag();
  }
  if (this->Dragged >= 0)
  {
    const double value = this->Axis.ToValue(event->pos().x() + this->GrabOffset);
    this->MoveTo(this->Dragged, this->Axis.Snap(value));
  }
  this->setCursor(this->FindHandle(event->pos()) >= 0 ? Qt::SizeHorCursor : Qt::ArrowCursor);
  this->update();
}

void pqIsovalueChart::mouseReleaseEvent(QMouseEvent* event)
{
  this->Panning = this->Panning && event->button() != Qt::MiddleButton;
  if (event->button() == Qt::LeftButton)
  {
    this->EndDrag();
  }
}

void pqIsovalueChart::mouseDoubleClickEvent(QMouseEvent* event)
{
  if (event->button() != Qt::LeftButton || this->FindHandle(event->pos()) >= 0)
  {
    return;
  }
  this->Isovalues.push_back(this->Axis.Snap(this->Axis.ToValue(event->pos().x())));
  this->Selected = static_cast<int>(this->Isovalues.size()) - 1;
  this->update();
  Q_EMIT this->isovaluesChanged();
}

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

void pqIsovalueChart::keyPressEvent(QKeyEvent* event)
{
  const auto handles = static_cast<int>(this->Isovalues.size());
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

void pqIsovalueChart::leaveEvent(QEvent* event)
{
  this->Hovering = false;
  this->update();
  QWidget::leaveEvent(event);
}

QStringList pqIsovalueChart::DescribeIsovalue(double isovalue) const
{
  QStringList lines = isosurface::DescribeIsosurface(this->GetSpectrum(), isovalue, this->Stored);
  if (this->Words && !this->GetSpectrum().IsEmpty())
  {
    lines += this->Words(this->GetSpectrum().Forecast(isovalue)); // empty: nothing is known
    lines.removeAll(QString());
  }
  return lines;
}

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
  if (this->Hovering && !this->GetSpectrum().IsEmpty() && this->GetPlot().contains(this->Hover))
  {
    isovalue = this->Axis.Snap(this->Axis.ToValue(this->Hover.x()));
    return true;
  }
  return false;
}

QString pqIsovalueChart::GetReadout() const
{
  double isovalue = 0;
  return this->FindReadoutIsovalue(isovalue) ? this->DescribeIsovalue(isovalue).join("; ")
                                             : QString();
}

void pqIsovalueChart::paintEvent(QPaintEvent*)
{
  QPainter painter(this);
  const QRect plot = this->GetPlot();
  painter.fillRect(plot, this->palette().base());
  this->Plot.PaintCurves(painter, plot, this->Axis, this->palette());
  this->Plot.PaintAxes(painter, plot, this->Axis, this->palette());
  painter.setPen(this->palette().text().color());
  // Beside the numbers of the scale: the right side may be out of sight in a narrow panel.
  const int scale = painter.fontMetrics().horizontalAdvance(" 00.0 k ");
  painter.drawText(plot.adjusted(scale, 2, 0, 0), Qt::AlignLeft | Qt::AlignTop, this->GetNote());
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

void pqIsovalueChart::PaintHandle(QPainter& painter, int handle) const
{
  isosurface::HandleLook look;
  look.Color = this->GetColor(handle);
  look.Outline = this->palette().windowText().color();
  look.Selected = handle == this->Selected;
  isosurface::PaintHandle(
    painter, this->GetPlot(), this->Axis.ToPixel(this->Isovalues[handle]), look);
}

void pqIsovalueChart::PaintReadout(QPainter& painter) const
{
  double isovalue = 0;
  if (!this->FindReadoutIsovalue(isovalue))
  {
    return;
  }
  const QRect plot = this->GetPlot();
  const int x = static_cast<int>(std::lround(this->Axis.ToPixel(isovalue)));
  if (this->Hovering && this->Dragged < 0 && this->FindHandle(this->Hover) < 0)
  {
    painter.setPen(QPen(this->palette().windowText().color(), 1, Qt::DotLine));
    painter.drawLine(x, plot.top(), x, plot.bottom());
  }
  isosurface::PaintReadout(painter, plot, x, this->DescribeIsovalue(isovalue), this->palette());
}
