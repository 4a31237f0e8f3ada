// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PassingFilters_h
#define isosurface_PassingFilters_h

class vtkAlgorithm;

namespace isosurface
{

/// Which point arrays of its input an algorithm hands on unchanged.
enum class PassedArrays
{
  None,   ///< it may change samples; an unknown algorithm
  Chosen, ///< some of them, as its user chose
  All
};

/// Looks the algorithm up in the one list of filters that are known to hand samples on unchanged:
/// vtkPVPostFilter (which ParaView puts behind every source and filter), vtkPassThrough,
/// vtkPassArrays, vtkPassSelectedArrays and their subclasses. Null gives None.
PassedArrays FindPassedArrays(vtkAlgorithm* algorithm);

} // namespace isosurface

#endif
