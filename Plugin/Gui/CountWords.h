// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CountWords_h
#define isosurface_CountWords_h

#include <QString>
#include <QStringList>

namespace isosurface
{

class SpectrumCurve;

/// A count in at most four digits: 850, 12.3 k, 1.2 M, 3.46 G.
QString FormatCount(double count);

/// Bytes: 850 B, 12.3 KiB, 1.2 MiB.
QString FormatBytes(double bytes);

/// Digits that tell two doubles of an axis apart, and no more.
QString FormatValue(double value);

/// Seconds: 2 ms, 0.3 s, 12 s, 3 min.
QString FormatSeconds(double seconds);

/// A level of detail: full resolution, 1/2 resolution, 1/4 resolution.
QString FormatResolution(int level);

/// The isovalue, and what its isosurface is, as far as a spectrum knows it, a line each. stored:
/// whether its blocks are read from files; else they lie in memory.
QStringList DescribeIsosurface(const SpectrumCurve& spectrum, double isovalue, bool stored);

} // namespace isosurface

#endif
