// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Refinement_h
#define isosurface_Refinement_h

#include <array>
#include <type_traits>

namespace isosurface
{

/// The number of parts in which ranks agree on shares.
constexpr double Millionths = 1e6;

/// How far the work beside a window is: on the surface or slice that follows a coarse one, on the spectrum
/// of images, or on the index of a file of which a sample is shown.
enum class RefinementStage
{
  None = 0,     ///< what is shown is final, or nothing was made since the last change
  Working = 1,  ///< the work goes on
  Ready = 2,    ///< all ranks have the result: to show it costs next to nothing
  TooLarge = 3, ///< the surface is not extracted, since it would not fit into memory
  Growing = 4,  ///< the surface of a sample becomes exact where its file is indexed meanwhile
  Failed = 5    ///< the index cannot be written
};

/// What a window polls; the stage is equal on all ranks. What a work does not have stays as it is here.
struct Refinement
{
  RefinementStage Stage = RefinementStage::None;
  int ShownLevel = 0;
  int NextLevel = 0;    ///< that is being extracted
  int FinalLevel = 0;   ///< the level without which the surface is not final
  int FittingLevel = 0; ///< the finest level that fits into memory
  double Share =
    0; ///< of the work that is done, 0 to 1; negative: an index waits for a larger budget
  double Triangles = 0; ///< of the next level, estimated, of all ranks
  double Bytes = 0;     ///< of memory that these need on a rank; of an index: that were fetched
  double FreeBytes =
    0; ///< of memory that the rank with the minimum has; of an index: that may be; 0: unknown
  double Seconds = -1; ///< that the index still takes; negative: unknown

  /// All members, in their order, as the elements of a property of ParaView.
  using Values = std::array<double, 10>;
  Values ToValues() const
  {
    Values values{};
    double* next = values.data();
    VisitMembers(*this, [&](const auto& member) { *next++ = static_cast<double>(member); });
    return values;
  }
  /// `values`: those that ToValues gave.
  static Refinement FromValues(const double* values)
  {
    Refinement refinement;
    VisitMembers(refinement,
      [&](auto& member) { member = static_cast<std::decay_t<decltype(member)>>(*values++); });
    return refinement;
  }

private:
  template <typename Self, typename Visit>
  static void VisitMembers(Self& self, const Visit& visit)
  {
    visit(self.Stage);
    visit(self.ShownLevel);
    visit(self.NextLevel);
    visit(self.FinalLevel);
    visit(self.FittingLevel);
    visit(self.Share);
    visit(self.Triangles);
    visit(self.Bytes);
    visit(self.FreeBytes);
    visit(self.Seconds);
  }
};

} // namespace isosurface

#endif
