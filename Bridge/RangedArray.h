// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RangedArray_h
#define isosurface_RangedArray_h

#include "IsosurfaceBridgeModule.h" // for the export macro

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <string>
#include <type_traits>
#include <vector>

class vtkDataArray;
class vtkDataObject;

namespace isosurface
{

/**
 * An array of one of VTK's numeric types, empty, that believes the ranges that are stored in it
 * where VTK keeps those that it has computed (vtkDataArray::PER_COMPONENT, L2_NORM_RANGE and their
 * finite counterparts), also when it is asked through the attributes that it belongs to
 * (vtkFieldData::GetRange): these compute ranges anew, by all values that are no ghosts, and
 * ParaView asks them since 5.13. Before VTK 9.2, whose attributes have no ranges, it is a plain
 * array.
 *
 * To VTK it is the array class of its type, and so are its copies; those that own their values know
 * no ranges. A range that is not stored is computed, as it is after the array was modified.
 * @param type VTK_FLOAT and so on; of a type that is no number, the array is plain.
 */
ISOSURFACEBRIDGE_EXPORT vtkSmartPointer<vtkDataArray> MakeRangedArray(int type);

/// Gives an array the memory of a Buffer that released it, which has `values` values; the array
/// releases it in turn.
ISOSURFACEBRIDGE_EXPORT void AdoptMemory(vtkDataArray* array, void* memory, vtkIdType values);

/// Gives an array room for `tuples` tuples, which are not initialised. Throws std::bad_alloc if memory
/// is short, where the array itself, as some systems build VTK, would end the process.
ISOSURFACEBRIDGE_EXPORT void AllocateTuples(vtkDataArray* array, vtkIdType tuples);

/// An array of one of VTK's numeric types, plain, of one component with these values.
ISOSURFACEBRIDGE_EXPORT vtkSmartPointer<vtkDataArray> MakeColumn(
  const std::string& name, int type, const std::vector<double>& values);

/// Adds an array of one number to a dataset's field data, of float64 or of VTK's ids.
ISOSURFACEBRIDGE_EXPORT void AddToFieldData(
  vtkDataObject* data, const std::string& name, int type, double value);
template <typename T>
void AddToFieldData(vtkDataObject* data, const std::string& name, T value)
{
  AddToFieldData(
    data, name, std::is_floating_point_v<T> ? VTK_DOUBLE : VTK_ID_TYPE, static_cast<double>(value));
}

} // namespace isosurface

#endif
