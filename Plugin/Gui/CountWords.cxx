// SPDX-License-Identifier: BSD-3-Clause
#include "CountWords.h"

#include "SpectrumCurve.h"

#include <QCoreApplication>

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

QString FormatValue(double value)
{
  return QString::number(value, 'g', 7);
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

QString FormatResolution(int level)
{
  return level == 0
    ? QCoreApplication::translate("CountWords", "full resolution")
    : QCoreApplication::translate("CountWords", "1/%1 resolution").arg(std::ldexp(1.0, level));
}

QStringList DescribeIsosurface(const SpectrumCurve& spectrum, double isovalue, bool stored)
{
  const auto translate = [](const char* text)
  { return QCoreApplication::translate("pqIsovalueChart", text); };
  QStringList lines = { FormatValue(isovalue) };
  if (spectrum.IsEmpty())
  {
    return lines;
  }
  const IsosurfaceForecast forecast = spectrum.Forecast(isovalue);
  lines.push_back(translate("%1 triangles").arg(FormatCount(forecast.Triangles)));
  if (spectrum.Knows(SpectrumCurve::Quantity::ActiveBlocks))
  {
    lines.push_back(translate(stored ? "%1 blocks, %2 to read" : "%1 blocks, %2")
                      .arg(FormatCount(forecast.Blocks))
                      .arg(FormatBytes(forecast.Bytes)));
  }
  return lines;
}

} // namespace isosurface
