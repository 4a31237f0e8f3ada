// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_RankScene_h
#define isosurface_Testing_RankScene_h

#include "vtkNew.h"
#include "vtkSmartPointer.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

class vtkActor;
class vtkIceTCompositePass;
class vtkIceTSynchronizedRenderers;
class vtkMetabufferPass;
class vtkRenderer;
class vtkRenderPass;
class vtkRenderWindow;
class vtkSynchronizedRenderWindows;

namespace isosurface
{

int GetRank();
int GetNumberOfRanks();
bool IsTrueOnSomeRank(bool mine);

/// The image of a tile; empty on ranks without one.
struct Image
{
  int Width = 0;
  int Height = 0;
  std::vector<std::uint32_t> Colors; ///< red, green, blue, alpha in the order of addresses
  std::vector<float> Depths;         ///< empty if they were not merged

  bool IsEmpty() const { return this->Colors.empty(); }
  std::size_t CountActive() const;
};

std::size_t CountDifferentColors(const Image& a, const Image& b);
std::size_t CountDifferentDepths(const Image& a, const Image& b);

struct CameraPlace
{
  std::string Name;
  std::array<double, 3> Position{};
  std::array<double, 3> FocalPoint{};
  double ViewAngle = 30;
  double ParallelScale = 0; ///< 0: perspective
  std::array<double, 2> ClippingRange{};
};

/// Views of the unit cube: far away, near, inside, beside it, parallel.
std::vector<CameraPlace> GetCameraPlaces();

/// Makes the actors of a rank, of `ranks` ranks.
using SceneMaker = std::function<std::vector<vtkSmartPointer<vtkActor>>(int rank, int ranks)>;

struct Scene
{
  std::string Name;
  SceneMaker Make;
};

/// Balls dealt out at random or in compact pieces, nested ones, ranks without anything, lines,
/// points.
std::vector<Scene> GetScenes();

/// One large ball a rank, one behind the other as seen from "far away"; rank 0 has the nearest.
std::vector<vtkSmartPointer<vtkActor>> MakeRowOfBalls(int rank, int ranks);

/// Renders a scene in one window a rank, merged by vtkIceTSynchronizedRenderers or by ours.
class RankWindow
{
public:
  enum Kind
  {
    Stock,
    Metabuffer
  };
  RankWindow(Kind kind, int width, int height, int columns = 1, int rows = 1);
  ~RankWindow();

  void SetScene(const Scene& scene);
  void SetCamera(const CameraPlace& camera);
  /// Collective: a frame of all ranks.
  Image Render();
  /// Null for Stock.
  vtkMetabufferPass* GetPass();
  vtkIceTCompositePass* GetIceTPass();
  vtkRenderer* GetRenderer() { return this->Renderer; }
  /// What draws the props; null for the default.
  void SetRenderPass(vtkRenderPass* pass);
  /// The colors that the window shows after a frame, with background.
  std::vector<std::uint32_t> GetShownColors();

private:
  vtkNew<vtkRenderWindow> Window;
  vtkNew<vtkRenderer> Renderer;
  vtkNew<vtkSynchronizedRenderWindows> Windows;
  vtkSmartPointer<vtkIceTSynchronizedRenderers> Renderers;
};

/// Draws actors in a window of this rank, without merging.
Image RenderAlone(const std::vector<vtkSmartPointer<vtkActor>>& actors, const CameraPlace& camera,
  int width, int height);

} // namespace isosurface

#endif
