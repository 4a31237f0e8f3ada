// SPDX-License-Identifier: BSD-3-Clause
#include "CountWords.h"

#include <QStringList>

#include <cmath>

namespace isosurface
{
namespace
{

/// Three digits, without an exponent.
QString FormatShort(double value)
{
  const int decimals = value < 9.995 ? 2 : value < 99.95 ? 1 : 0;
  return QString::number(value, 'f', decimals);
}

QString FormatScaled(double value, double base, const QStringList& units)
{
  int unit = 0;
  // 999.6 of a unit would be rounded to 1000 of it.
  while (value >= base * (1 - 5e-4) && unit + 1 < units.size())
  {
    value /= base;
    ++unit;
  }
  const QString number =
    unit == 0 ? QString::number(value, 'g', 3 + (value >= 999.5)) : FormatShort(value);
  return units[unit].isEmpty() ? number : number + " " + units[unit];
}

} // namespace

QString FormatCount(double count)
{
  return FormatScaled(count, 1000, { "", "k", "M", "G", "T" });
}

QString FormatBytes(double bytes)
{
  return FormatScaled(std::round(bytes), 1024, { "B", "KiB", "MiB", "GiB", "TiB" });
}

QString FormatSeconds(double seconds)
{
  if (seconds < 0.0995)
  {
    return QString::number(std::max(1.0, std::round(seconds * 1000))) + " ms";
  }
  if (seconds < 9.95)
  {
    return QString::number(seconds, 'f', 1) + " s";
  }
  return seconds < 119.5 ? QString::number(std::round(seconds)) + " s"
                         : QString::number(std::round(seconds / 60)) + " min";
}

} // namespace isosurface
