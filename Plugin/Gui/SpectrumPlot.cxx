// SPDX-License-Identifier: BSD-3-Clause
#include "SpectrumPlot.h"

#include "CountWords.h"
#include "ValueAxis.h"

#include <QFontMetrics>
#include <QPainter>
#include <QPainterPath>
#include <QPalette>
#include <QPolygonF>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace isosurface
{
namespace
{

constexpr int TickSpacing = 60;
constexpr int TickLength = 4;
constexpr double HistogramDecades = 5; ///< that are drawn, below the highest peak
constexpr double HistogramHeight = 0.9;

/// Where the least positive value stands on a logarithmic scale: a little above the bottom, which
/// is 0.
constexpr double LogarithmicBase = 0.06;

/// Of the spectrum: legible on light and dark grounds.
const QColor CurveColor(52, 120, 190);

} // namespace

void SpectrumPlot::SetSpectrum(const SpectrumCurve& spectrum)
{
  this->Spectrum = spectrum;
  this->Histogram = spectrum.MakeHistogram();
  this->SetQuantity(this->Drawn);
}

void SpectrumPlot::SetQuantity(Quantity quantity)
{
  this->Drawn = quantity;
  this->Logarithmic = this->Spectrum.SpansDecades(quantity);
  this->Minimum = std::numeric_limits<double>::infinity();
  this->Maximum = 0;
  for (const double value : this->Spectrum.Get(quantity))
  {
    this->Minimum = value > 0 ? std::min(this->Minimum, value) : this->Minimum;
    this->Maximum = std::max(this->Maximum, value);
  }
}

double SpectrumPlot::GetHeight(double value) const
{
  if (!(value > 0))
  {
    return 0;
  }
  if (!this->Logarithmic)
  {
    return value / this->Maximum;
  }
  const double decades = std::log10(this->Maximum / this->Minimum);
  return LogarithmicBase + (1 - LogarithmicBase) * std::log10(value / this->Minimum) / decades;
}

void SpectrumPlot::PaintCurves(
  QPainter& painter, const QRect& plot, const ValueAxis& axis, const QPalette& palette) const
{
  if (this->Spectrum.IsEmpty())
  {
    return;
  }
  painter.save();
  painter.setClipRect(plot);
  this->PaintHistogram(painter, plot, axis, palette);
  this->PaintCurve(painter, plot, axis);
  painter.restore();
}

std::vector<double> SpectrumPlot::MakeHistogramColumns(
  const QRect& plot, const ValueAxis& axis) const
{
  const std::vector<double>& isovalues = this->Spectrum.GetIsovalues();
  const double width = plot.width();
  std::vector<double> columns(static_cast<std::size_t>(plot.width()), 0.0);
  for (std::size_t bin = 0; bin < this->Histogram.size(); ++bin)
  {
    const double from = axis.ToPixel(isovalues[bin]) - plot.left();
    const double to = axis.ToPixel(isovalues[bin + 1]) - plot.left();
    const int first = static_cast<int>(std::clamp(from, 0.0, width));
    const int last = static_cast<int>(std::clamp(std::ceil(to), 0.0, width));
    for (int column = first; column < last; ++column)
    {
      double& height = columns[static_cast<std::size_t>(column)];
      height = std::max(height, this->Histogram[bin]);
    }
  }
  return columns;
}

void SpectrumPlot::PaintHistogram(
  QPainter& painter, const QRect& plot, const ValueAxis& axis, const QPalette& palette) const
{
  const std::vector<double> columns = this->MakeHistogramColumns(plot, axis);
  const double highest = columns.empty() ? 0 : *std::max_element(columns.begin(), columns.end());
  if (!(highest > 0))
  {
    return;
  }
  QColor grey = palette.text().color();
  grey.setAlpha(45);
  const double full = (plot.height() - 2) * HistogramHeight;
  for (int column = 0; column < plot.width(); ++column)
  {
    // On a logarithmic scale: peaks hide all else on a linear one.
    const double share = columns[static_cast<std::size_t>(column)] / highest;
    const double height = share > 0 ? std::max(0.0, 1 + std::log10(share) / HistogramDecades) : 0;
    const int pixels = static_cast<int>(height * full);
    painter.fillRect(plot.left() + column, plot.bottom() + 1 - pixels, 1, pixels, grey);
  }
}

void SpectrumPlot::PaintCurve(QPainter& painter, const QRect& plot, const ValueAxis& axis) const
{
  const std::vector<double>& isovalues = this->Spectrum.GetIsovalues();
  const std::vector<double>& values = this->Spectrum.Get(this->Drawn);
  if (values.empty())
  {
    return;
  }
  const double bottom = plot.bottom() + 1;
  const double span = plot.height() - 2;
  QPainterPath curve;
  for (std::size_t index = 0; index < values.size(); ++index)
  {
    const QPointF point(
      axis.ToPixel(isovalues[index]), bottom - this->GetHeight(values[index]) * span);
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
  curve.lineTo(axis.ToPixel(isovalues.back()), bottom);
  curve.lineTo(axis.ToPixel(isovalues.front()), bottom);
  line.setAlpha(30);
  painter.fillPath(curve, line);
}

void SpectrumPlot::PaintAxes(
  QPainter& painter, const QRect& plot, const ValueAxis& axis, const QPalette& palette) const
{
  const QFontMetrics metrics = painter.fontMetrics();
  const int bottom = plot.bottom() + 1;
  painter.setPen(palette.windowText().color());
  painter.drawLine(plot.left(), bottom, plot.right(), bottom);
  for (const double tick : axis.MakeTicks(TickSpacing))
  {
    const int x = static_cast<int>(std::lround(axis.ToPixel(tick)));
    const QString label = FormatValue(tick);
    const int width = metrics.horizontalAdvance(label);
    const int room = plot.left() + plot.right() + 1; // the margins are alike
    const int left = std::clamp(x - width / 2, 0, std::max(0, room - width));
    painter.drawLine(x, bottom, x, bottom + TickLength - 1);
    painter.drawText(left, bottom + TickLength - 1 + metrics.ascent(), label);
  }
  this->PaintScale(painter, plot, palette);
}

void SpectrumPlot::PaintScale(QPainter& painter, const QRect& plot, const QPalette& palette) const
{
  if (this->Spectrum.Get(this->Drawn).empty() || !(this->Maximum > 0))
  {
    return;
  }
  const QFontMetrics metrics = painter.fontMetrics();
  QColor faint = palette.windowText().color();
  faint.setAlpha(110);
  painter.setPen(faint);
  const double span = plot.height() - 2;
  int lastLabel = std::numeric_limits<int>::max();
  const auto label = [&](double value)
  {
    const int y = static_cast<int>(std::lround(plot.bottom() + 1 - this->GetHeight(value) * span));
    painter.drawLine(plot.left(), y, plot.left() + TickLength, y);
    if (std::abs(lastLabel - y) > metrics.height() && y - plot.top() < plot.height() - 4)
    {
      const int baseline = std::max(plot.top() + metrics.ascent(), y + metrics.ascent() / 2);
      painter.drawText(plot.left() + TickLength + 2, baseline, FormatCount(value));
      lastLabel = y;
    }
  };
  label(this->Maximum);
  if (this->Logarithmic)
  {
    const int lowest = static_cast<int>(std::ceil(std::log10(this->Minimum)));
    for (int exponent = static_cast<int>(std::floor(std::log10(this->Maximum))); exponent >= lowest;
         --exponent)
    {
      label(std::pow(10.0, exponent));
    }
  }
}

namespace
{

constexpr int GripWidth = 12;
constexpr int ReadoutMargin = 4;
constexpr int ReadoutDistance = 8; ///< from the column

} // namespace

void PaintHandle(QPainter& painter, const QRect& plot, double x, const HandleLook& look)
{
  const bool visible = x >= plot.left() - 0.5 && x <= plot.right() + 0.5;
  const double place = std::clamp(x, 1.0 * plot.left(), 1.0 * plot.right());
  painter.save();
  painter.setRenderHint(QPainter::Antialiasing);
  QPolygonF grip;
  if (visible)
  {
    const double width = look.Selected ? 2.5 : 1.5;
    const QPointF top(place, GripHeight);
    const QPointF bottom(place, plot.bottom() + 1);
    QColor shadow = look.Outline;
    shadow.setAlpha(120);
    painter.setPen(QPen(shadow, width + 1.5));
    painter.drawLine(top, bottom);
    painter.setPen(QPen(look.Color, width));
    painter.drawLine(top, bottom);
    grip << QPointF(place - GripWidth / 2.0, 1) << QPointF(place + GripWidth / 2.0, 1)
         << QPointF(place, GripHeight + 1);
  }
  else
  {
    const double back = x < plot.left() ? GripHeight : -GripHeight;
    grip << QPointF(place, GripHeight / 2.0 + 1) << QPointF(place + back, 1)
         << QPointF(place + back, GripHeight + 1);
  }
  painter.setPen(QPen(look.Outline, look.Selected ? 1.6 : 0.8));
  painter.setBrush(look.Color);
  painter.drawPolygon(grip);
  painter.restore();
}

void PaintReadout(
  QPainter& painter, const QRect& plot, int x, const QStringList& lines, const QPalette& palette)
{
  const QFontMetrics metrics = painter.fontMetrics();
  int width = 0;
  for (const QString& line : lines)
  {
    width = std::max(width, metrics.horizontalAdvance(line));
  }
  QRect box(
    0, plot.top() + 2, width + 2 * ReadoutMargin, lines.size() * metrics.height() + ReadoutMargin);
  const int right = x + ReadoutDistance;
  box.moveLeft(
    right + box.width() <= plot.right() ? right : std::max(0, x - ReadoutDistance - box.width()));
  QColor ground = palette.toolTipBase().color();
  ground.setAlpha(230);
  painter.setPen(palette.toolTipText().color());
  painter.setBrush(ground);
  painter.drawRect(box);
  for (int line = 0; line < lines.size(); ++line)
  {
    painter.drawText(box.left() + ReadoutMargin,
      box.top() + ReadoutMargin / 2 + line * metrics.height() + metrics.ascent(), lines[line]);
  }
}

} // namespace isosurface
