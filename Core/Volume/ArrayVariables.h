// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArrayVariables_h
#define isosurface_ArrayVariables_h

#include "Volume/ValueType.h"

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
};

/// A scalar on the vertices of the grid that can be contoured.
struct Variable
{
  /// As Component: the magnitude of the array's tuples.
  static constexpr int Magnitude = -1;

  std::size_t Array = 0;
  int Component = 0;
  ValueType Type = ValueType::UInt8; ///< the array's; of magnitudes Float64

  bool IsMagnitude() const { return this->Component == Magnitude; }
};

/**
 * All variables of some arrays, by number. First come the components, which are what is stored:
 * those of array 0, of array 1, ... Then the magnitudes, which are computed: one of each array of
 * several components, in the arrays' order. So if all arrays have one component, a variable has the
 * number of its array.
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
  /// Variables below this number are stored, one segment a level each.
  std::size_t GetNumberOfStored() const { return this->StoredTypes.size(); }
  const std::vector<ValueType>& GetStoredTypes() const { return this->StoredTypes; }

  int GetComponents(std::size_t array) const { return this->Components[array]; }
  /// The number of an array's component 0; the others follow it.
  std::size_t GetFirst(std::size_t array) const { return this->First[array]; }

  /// The variable of a component or of the magnitude. An array of one component is its own
  /// magnitude. Nothing if there is no such array or component.
  std::optional<std::size_t> Find(std::size_t array, int component) const;

  /// The variable that a menu of components means, as ParaView numbers its entries: below the
  /// array's number of components that component, at it the magnitude. An array of one component
  /// has no such menu: any number means the array.
  std::optional<std::size_t> FindChoice(std::size_t array, int choice) const;

private:
  std::vector<Variable> Variables;
  std::vector<ValueType> StoredTypes;
  std::vector<int> Components;
  std::vector<std::size_t> First;
};

/// The component, or Variable::Magnitude, that such a menu means for an array of so many
/// components.
std::optional<int> FindChosenComponent(int components, int choice);

} // namespace isosurface

#endif
