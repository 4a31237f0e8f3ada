// SPDX-License-Identifier: BSD-3-Clause
#include "RangedArray.h"

#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationDoubleVectorKey.h"
#include "vtkInformationInformationVectorKey.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkLongLongArray.h"
#include "vtkObjectFactory.h"
#include "vtkShortArray.h"
#include "vtkSignedCharArray.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnsignedIntArray.h"
#include "vtkUnsignedLongLongArray.h"
#include "vtkUnsignedShortArray.h"
#include "vtkVersionMacros.h"

#include "Ground/Base/Buffer.h"
#include "Ground/Base/KeptMemory.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#define ISOSURFACE_ATTRIBUTES_HAVE_RANGES (VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0))

namespace isosurface
{
namespace
{

#if ISOSURFACE_ATTRIBUTES_HAVE_RANGES

/// Finds the stored ranges of all components; false if they are not.
bool FindRanges(vtkDataArray* array, vtkInformationInformationVectorKey* key, double* ranges)
{
  vtkInformationVector* components =
    array->HasInformation() ? array->GetInformation()->Get(key) : nullptr;
  const int count = array->GetNumberOfComponents();
  if (!components || components->GetNumberOfInformationObjects() != count)
  {
    return false;
  }
  for (int component = 0; component < count; ++component)
  {
    const double* range =
      components->GetInformationObject(component)->Get(vtkDataArray::COMPONENT_RANGE());
    if (!range)
    {
      return false;
    }
    std::copy(range, range + 2, ranges + 2 * component);
  }
  return true;
}

/// Finds the stored range of the norm; false if it is not.
bool FindRange(vtkDataArray* array, vtkInformationDoubleVectorKey* key, double range[2])
{
  if (!array->HasInformation() || !array->GetInformation()->Has(key))
  {
    return false;
  }
  array->GetInformation()->Get(key, range);
  return true;
}

/// vtkFieldData calls these four functions, and vtkDataArray itself only where no range is stored.
template <typename ArrayT>
class RangedArray : public ArrayT
{
public:
  static RangedArray* New() { VTK_STANDARD_NEW_BODY(RangedArray); }

protected:
  using ArrayT::ComputeFiniteScalarRange;
  using ArrayT::ComputeFiniteVectorRange;
  using ArrayT::ComputeScalarRange;
  using ArrayT::ComputeVectorRange;

  bool ComputeScalarRange(
    double* ranges, const unsigned char* ghosts, unsigned char ghostsToSkip) override
  {
    return FindRanges(this, vtkDataArray::PER_COMPONENT(), ranges) ||
      this->ArrayT::ComputeScalarRange(ranges, ghosts, ghostsToSkip);
  }

  bool ComputeFiniteScalarRange(
    double* ranges, const unsigned char* ghosts, unsigned char ghostsToSkip) override
  {
    return FindRanges(this, vtkDataArray::PER_FINITE_COMPONENT(), ranges) ||
      this->ArrayT::ComputeFiniteScalarRange(ranges, ghosts, ghostsToSkip);
  }

  bool ComputeVectorRange(
    double range[2], const unsigned char* ghosts, unsigned char ghostsToSkip) override
  {
    return FindRange(this, vtkDataArray::L2_NORM_RANGE(), range) ||
      this->ArrayT::ComputeVectorRange(range, ghosts, ghostsToSkip);
  }

  bool ComputeFiniteVectorRange(
    double range[2], const unsigned char* ghosts, unsigned char ghostsToSkip) override
  {
    return FindRange(this, vtkDataArray::L2_NORM_FINITE_RANGE(), range) ||
      this->ArrayT::ComputeFiniteVectorRange(range, ghosts, ghostsToSkip);
  }
};

#else

template <typename ArrayT>
using RangedArray = ArrayT;

#endif

template <typename ArrayT>
vtkSmartPointer<vtkDataArray> Make()
{
  return vtkSmartPointer<vtkDataArray>::Take(RangedArray<ArrayT>::New());
}

} // namespace

vtkSmartPointer<vtkDataArray> MakeRangedArray(int type)
{
  switch (type)
  {
    case VTK_SIGNED_CHAR:
      return Make<vtkSignedCharArray>();
    case VTK_UNSIGNED_CHAR:
      return Make<vtkUnsignedCharArray>();
    case VTK_SHORT:
      return Make<vtkShortArray>();
    case VTK_UNSIGNED_SHORT:
      return Make<vtkUnsignedShortArray>();
    case VTK_INT:
      return Make<vtkIntArray>();
    case VTK_UNSIGNED_INT:
      return Make<vtkUnsignedIntArray>();
    case VTK_LONG_LONG:
      return Make<vtkLongLongArray>();
    case VTK_UNSIGNED_LONG_LONG:
      return Make<vtkUnsignedLongLongArray>();
    case VTK_ID_TYPE:
      return Make<vtkIdTypeArray>();
    case VTK_FLOAT:
      return Make<vtkFloatArray>();
    case VTK_DOUBLE:
      return Make<vtkDoubleArray>();
    default:
      return vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  }
}

void AdoptMemory(vtkDataArray* array, void* memory, vtkIdType values)
{
  array->SetVoidArray(memory, values, 0, vtkAbstractArray::VTK_DATA_ARRAY_USER_DEFINED);
  array->SetArrayFreeFunction(&ReleaseMemory);
}

void AllocateTuples(vtkDataArray* array, vtkIdType tuples)
{
  const vtkIdType values = tuples * array->GetNumberOfComponents();
  Buffer<std::uint8_t> memory(static_cast<std::size_t>(values * array->GetDataTypeSize()));
  AdoptMemory(array, memory.Release(), values);
}

vtkSmartPointer<vtkDataArray> MakeColumn(
  const std::string& name, int type, const std::vector<double>& values)
{
  auto column = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  column->SetName(name.c_str());
  AllocateTuples(column, static_cast<vtkIdType>(values.size()));
  for (std::size_t row = 0; row < values.size(); ++row)
  {
    column->SetComponent(static_cast<vtkIdType>(row), 0, values[row]);
  }
  return column;
}

void AddToFieldData(vtkDataObject* data, const std::string& name, int type, double value)
{
  data->GetFieldData()->AddArray(MakeColumn(name, type, { value }));
}

} // namespace isosurface
