// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ChartMarks_h
#define isosurface_ChartMarks_h

#include <QColor>
#include <QRect>
#include <QStringList>

class QPainter;
class QPalette;

namespace isosurface
{

constexpr int GripHeight = 11; ///< of the triangle atop a handle

/// How a handle looks.
struct HandleLook
{
  QColor Color;
  QColor Outline;
  bool Selected = false;
};

/// Draws a handle at a pixel column: a line through the plot with a grip above it. One that is out
/// of sight leaves its grip at the side where it is.
void PaintHandle(QPainter& painter, const QRect& plot, double x, const HandleLook& look);

/// Draws lines of text in a box beside a pixel column, on the side that has room.
void PaintReadout(
  QPainter& painter, const QRect& plot, int x, const QStringList& lines, const QPalette& palette);

} // namespace isosurface

#endif
