// SPDX-License-Identifier: BSD-3-Clause
#ifndef TimedDisplay_h
#define TimedDisplay_h

#include "vtkNew.h"
#include "vtkSmartPointer.h"

#include <array>
#include <string>
#include <vector>

class TimedPass;
class vtkCallbackCommand;
class vtkIceTSynchronizedRenderers;
class vtkMPIController;
class vtkMetabufferPass;
class vtkRenderWindow;
class vtkRenderer;
class vtkSynchronizedRenderWindows;

/// One way to make frames, with the sums of what they cost. Times are of the slowest rank, counts of
/// all ranks.
struct Way
{
  std::string Name;
  int CompositeMode = -1; ///< of vtkMetabufferPass; -1: stock
  int Divisor = 1;
  bool HasBackground = false; ///< the divisor is that of the farther half of the ranks only
  bool SharesDepths = true;   ///< ranks tell each other of hidden triangles
  double Budget = 0;          ///< seconds of a frame; 0: none
  double SquaredError = 0;    ///< of colors, to the image of full resolution
  double RenderSeconds = 0;
  double ReadSeconds = 0;
  double DeliverSeconds = 0;
  double AfterSeconds = 0; ///< after rendering
  double WorkSeconds = 0;  ///< of processors after rendering, of all ranks
  double FrameSeconds = 0;
  double DrawnPixels = 0;
  double BytesSent = 0;
};

/// A window a rank whose images are merged, by stock compositing or ours, with the time of each step.
class TimedDisplay
{
public:
  /// `isApart`: no rank goes on before all have rendered.
  TimedDisplay(vtkMPIController* controller, int width, int height, bool isStock, bool isApart);
  ~TimedDisplay();

  vtkRenderer* GetRenderer() { return this->Renderer; }

  /// The root's image without background; empty on other ranks.
  std::vector<unsigned char> GetImage();

  /// Of a rank in the last frame; 0 if it drew nothing.
  int GetDivisor(int rank);

  /// Collective: adds the cost of a frame to the way. Returns the seconds of the slowest rank.
  double DrawFrame(Way& way);

private:
  void SetUpPass(const Way& way);
  void SetDivisors(const Way& way);
  void ReadCost(std::array<double, 5>& seconds, std::array<double, 3>& counts);
  vtkMetabufferPass* GetPass();

  vtkMPIController* Controller;
  vtkNew<vtkRenderWindow> Window;
  vtkNew<vtkRenderer> Renderer;
  vtkSmartPointer<TimedPass> Pass;
  vtkNew<vtkCallbackCommand> EndOfPasses;
  double BeginOfDelivery = 0;
  vtkNew<vtkSynchronizedRenderWindows> Windows;
  vtkSmartPointer<vtkIceTSynchronizedRenderers> Renderers;
};

#endif
