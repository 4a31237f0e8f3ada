// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TupleRanges_h
#define isosurface_TupleRanges_h

#include <cstddef>
#include <limits>
#include <vector>

namespace isosurface
{

/// The range of some values; empty if Minimum is above Maximum.
template <typename T>
struct ValueSpan
{
  T Minimum = std::numeric_limits<T>::max();
  T Maximum = std::numeric_limits<T>::lowest();

  void Add(const ValueSpan& other)
  {
    this->Minimum = other.Minimum < this->Minimum ? other.Minimum : this->Minimum;
    this->Maximum = other.Maximum > this->Maximum ? other.Maximum : this->Maximum;
  }
};

/// The ranges of an array of tuples. They are valid if all values are finite.
template <typename T>
struct TupleRanges
{
  std::vector<ValueSpan<T>> Components;
  ValueSpan<double> SquaredNorm; ///< of tuples of several components
  bool AreFinite = true;
};

/// The ranges of `tuples` tuples, one after the other. T: float, double, long or
/// long long (vtkIdType is one of these). Cost: one pass, on `threads` threads.
template <typename T>
TupleRanges<T> FindTupleRanges(
  const T* values, std::size_t tuples, std::size_t components, int threads);

} // namespace isosurface

#endif
