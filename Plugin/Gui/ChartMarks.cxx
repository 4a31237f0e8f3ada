// SPDX-License-Identifier: BSD-3-Clause
#include "ChartMarks.h"

#include <QFontMetrics>
#include <QPainter>
#include <QPalette>
#include <QPolygonF>

#include <algorithm>

namespace isosurface
{
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
