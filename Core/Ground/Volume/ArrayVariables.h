// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArrayVariables_h
#define isosurface_ArrayVariables_h

#include "Ground/Volume/ValueType.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// A named array of samples, or of tuples of samples, on the vertices of the grid.
struct ArrayDescription
{
  std::string Name;
  ValueType Type = ValueType::UInt8;
  int Components = 1;
  std::string Unit = {}; ///< of the samples, as "HU" (Hounsfield); empty if it is not known
};

/// A scalar on the vertices of the grid that can be contoured.
struct Variable
{
  /// As Component: the magnitude of the array's tuples.
  static constexpr int Magnitude = -1;

  std::size_t Array = 0;
  int Component = 0;
  ValueType Type = ValueType::UInt8; ///< the array's type; Float64 for magnitudes

  bool IsMagnitude() const { return this->Component == Magnitude; }
};

/**
 * Numbers the variables of several arrays. The components come first, those of array 0, of array 1,
 * and so on: they are stored on disk. The magnitudes follow, one for each array of several
 * components, in the order of the arrays: they are computed. So if all arrays have one component, a
 * variable has the number of its array.
 *
 *     density, velocity[3]:   0 density  1 velocity 0  2 velocity 1  3 velocity 2  4 |velocity|
 */
class ArrayVariables
{
public:
  ArrayVariables() = default;
  explicit ArrayVariables(const std::vector<ArrayDescription>& arrays);

  std::size_t GetCount() const { return this->Variables.size(); }
  const Variable& operator[](std::size_t variable) const { return this->Variables[variable]; }
  /// Variables below this number are stored: one segment for each level.
  std::size_t GetNumberOfStored() const { return this->StoredTypes.size(); }
  const std::vector<ValueType>& GetStoredTypes() const { return this->StoredTypes; }

  int GetComponents(std::size_t array) const { return this->Components[array]; }
  /// The variable of an array's component 0. The other components follow it.
  std::size_t GetFirst(std::size_t array) const { return this->First[array]; }

  /// The variable of a component, or of Variable::Magnitude. For an array of one component both are
  /// the same. Nothing if there is no such array or component.
  std::optional<std::size_t> Find(std::size_t array, int component) const;

  /// The variable of an entry of ParaView's menu of components: entry n is component n, and the
  /// entry after the last component is the magnitude. An array of one component has no such menu:
  /// any number means the array.
  std::optional<std::size_t> FindChoice(std::size_t array, int choice) const;

private:
  std::vector<Variable> Variables;
  std::vector<ValueType> StoredTypes;
  std::vector<int> Components;
  std::vector<std::size_t> First;
};

/// The component, or Variable::Magnitude, of an entry of that menu, for an array of `components`
/// components.
std::optional<int> FindChosenComponent(int components, int choice);

} // namespace isosurface

#endif
