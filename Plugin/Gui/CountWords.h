// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CountWords_h
#define isosurface_CountWords_h

#include <QString>

namespace isosurface
{

/// A count in at most four digits: 850, 12.3 k, 1.2 M, 3.46 G.
QString FormatCount(double count);

/// Bytes: 850 B, 12.3 KiB, 1.2 MiB.
QString FormatBytes(double bytes);

/// Seconds: 2 ms, 0.3 s, 12 s, 3 min.
QString FormatSeconds(double seconds);

} // namespace isosurface

#endif
