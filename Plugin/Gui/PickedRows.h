// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PickedRows_h
#define isosurface_PickedRows_h

#include <cstddef>
#include <vector>

namespace isosurface
{

/// The isovalues that selected rows of a spectrum stand for, in the order of the rows: a row alone
/// is one isovalue, several in a row are a range and give its two ends. column: the isovalues of all
/// rows. Rows beyond it are left out; they may come in any order and more than once.
std::vector<double> ChooseIsovalues(
  const std::vector<double>& column, std::vector<std::size_t> rows);

} // namespace isosurface

#endif
