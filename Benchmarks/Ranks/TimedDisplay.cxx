// SPDX-License-Identifier: BSD-3-Clause
#include "TimedDisplay.h"

#include "OpenGLFunctions.h"

#include "vtkActor.h"
#include "vtkActorCollection.h"
#include "vtkCallbackCommand.h"
#include "vtkCamera.h"
#include "vtkCommand.h"
#include "vtkIceTCompositePass.h"
#include "vtkIceTSynchronizedRenderers.h"
#include "vtkMPIController.h"
#include "vtkMath.h"
#include "vtkMetabufferPass.h"
#include "vtkMetabufferSynchronizedRenderers.h"
#include "vtkObjectFactory.h"
#include "vtkPVDefaultPass.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkSynchronizedRenderWindows.h"
#include "vtkTimerLog.h"
#include "vtkUnsignedCharArray.h"

#include <IceT.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

/// Draws, and measures the time until the image is there.
class TimedPass : public vtkRenderPass
{
public:
  /// Seconds of the wall clock, and of this rank's processor time.
  struct Clocks
  {
    double Wall = 0;
    double Work = 0;

    static Clocks Read()
    {
      return { vtkTimerLog::GetUniversalTime(),
        static_cast<double>(std::clock()) / CLOCKS_PER_SEC };
    }
  };

  static TimedPass* New();
  vtkTypeMacro(TimedPass, vtkRenderPass);
  void Render(const vtkRenderState* state) override
  {
    const double begin = vtkTimerLog::GetUniversalTime();
    this->Inner->Render(state);
    glFinish();
    this->Seconds += vtkTimerLog::GetUniversalTime() - begin;
    if (this->Controller)
    {
      this->Controller->Barrier();
    }
    this->End = Clocks::Read();
  }
  /// Makes a frame wait for all ranks after rendering; null, the default: it does not.
  void SetController(vtkMultiProcessController* controller) { this->Controller = controller; }
  double TakeSeconds() { return std::exchange(this->Seconds, 0.0); }
  /// When the last image was there; with a controller, those of all ranks.
  const Clocks& GetEnd() const { return this->End; }

private:
  vtkNew<vtkPVDefaultPass> Inner;
  vtkMultiProcessController* Controller = nullptr;
  double Seconds = 0;
  Clocks End;
};
vtkStandardNewMacro(TimedPass);

TimedDisplay::TimedDisplay(
  vtkMPIController* controller, int width, int height, bool isStock, bool isApart)
  : Controller(controller)
  , Pass(vtkSmartPointer<TimedPass>::New())
{
  this->Renderers = isStock ? vtkSmartPointer<vtkIceTSynchronizedRenderers>::New()
                            : vtkSmartPointer<vtkIceTSynchronizedRenderers>(
                                vtkSmartPointer<vtkMetabufferSynchronizedRenderers>::New());
  this->Window->SetMultiSamples(0);
  this->Window->SetOffScreenRendering(1);
  this->Window->SetSize(width, height);
  this->Window->AddRenderer(this->Renderer);
  this->Windows->SetRenderWindow(this->Window);
  this->Windows->SetParallelController(controller);
  static unsigned int identifier = 0;
  this->Windows->SetIdentifier(++identifier);
  this->Pass->SetController(isApart ? controller : nullptr);
  this->Renderers->SetRenderPass(this->Pass);
  this->Renderers->SetRenderer(this->Renderer);
  this->Renderers->SetParallelController(controller);
  this->Renderers->FixBackgroundOn();
  // This observer is called before the synchronizer, which delivers the image.
  this->EndOfPasses->SetClientData(&this->BeginOfDelivery);
  this->EndOfPasses->SetCallback(
    [](vtkObject*, unsigned long, void* time, void*)
    {
      glFinish();
      *static_cast<double*>(time) = vtkTimerLog::GetUniversalTime();
    });
  this->Renderer->AddObserver(vtkCommand::EndEvent, this->EndOfPasses, 1);
}

TimedDisplay::~TimedDisplay() = default;

vtkMetabufferPass* TimedDisplay::GetPass()
{
  return vtkMetabufferPass::SafeDownCast(this->Renderers->GetIceTCompositePass());
}

std::vector<unsigned char> TimedDisplay::GetImage()
{
  vtkSynchronizedRenderers::vtkRawImage tile;
  this->Renderers->GetIceTCompositePass()->GetLastRenderedTile(tile);
  if (!tile.IsValid())
  {
    return {};
  }
  const unsigned char* bytes = tile.GetRawPtr()->GetPointer(0);
  return { bytes, bytes + std::size_t{ 4 } * tile.GetWidth() * tile.GetHeight() };
}

int TimedDisplay::GetDivisor(int rank)
{
  std::array<int, 5> viewport{};
  this->GetPass()->GetViewport(rank, viewport.data());
  return viewport[4];
}

void TimedDisplay::SetUpPass(const Way& way)
{
  if (vtkMetabufferPass* pass = this->GetPass())
  {
    pass->SetCompositeMode(way.CompositeMode);
    this->SetDivisors(way);
    pass->SetFrameTimeBudget(way.Budget);
    pass->SetShareDepths(way.SharesDepths);
    pass->CollectDepthsOff();
  }
}

double TimedDisplay::DrawFrame(Way& way)
{
  this->SetUpPass(way);
  this->Controller->Barrier();
  const double begin = vtkTimerLog::GetUniversalTime();
  const bool isRoot = this->Controller->GetLocalProcessId() == 0;
  if (isRoot)
  {
    this->Window->Render();
    this->Controller->TriggerBreakRMIs();
  }
  else
  {
    this->Controller->ProcessRMIs();
  }
  const TimedPass::Clocks end = TimedPass::Clocks::Read();
  this->Controller->Barrier();
  const TimedPass::Clocks& rendered = this->Pass->GetEnd();
  // Render, read, deliver, frame, after.
  std::array<double, 5> seconds = { this->Pass->TakeSeconds(), 0,
    isRoot ? end.Wall - this->BeginOfDelivery : 0, vtkTimerLog::GetUniversalTime() - begin,
    end.Wall - rendered.Wall };
  // Pixels drawn, bytes sent, seconds worked.
  std::array<double, 3> counts{ 0, 0, end.Work - rendered.Work };
  this->ReadCost(seconds, counts);
  std::array<double, 5> slowest{};
  std::array<double, 3> all{};
  this->Controller->AllReduce(seconds.data(), slowest.data(), 5, vtkCommunicator::MAX_OP);
  this->Controller->AllReduce(counts.data(), all.data(), 3, vtkCommunicator::SUM_OP);
  way.RenderSeconds += slowest[0];
  way.ReadSeconds += slowest[1];
  way.DeliverSeconds += slowest[2];
  way.FrameSeconds += slowest[3];
  way.AfterSeconds += slowest[4];
  way.DrawnPixels += all[0];
  way.BytesSent += all[1];
  way.WorkSeconds += all[2];
  return slowest[3];
}

void TimedDisplay::ReadCost(std::array<double, 5>& seconds, std::array<double, 3>& counts)
{
  if (vtkMetabufferPass* pass = this->GetPass())
  {
    seconds[1] = pass->GetReadSeconds();
    counts[0] = static_cast<double>(pass->GetDrawnPixels());
    counts[1] = static_cast<double>(pass->GetBytesSent());
    return;
  }
  // IceT counts its callback that draws, reads back and clears.
  icetGetDoublev(ICET_RENDER_TIME, &seconds[1]);
  seconds[1] = std::max(0.0, seconds[1] - seconds[0]);
  const int* size = this->Window->GetActualSize();
  counts[0] = seconds[0] > 0 ? static_cast<double>(size[0]) * size[1] : 0;
  IceTInt bytes = 0;
  icetGetIntegerv(ICET_BYTES_SENT, &bytes);
  counts[1] = static_cast<double>(bytes);
}

void TimedDisplay::SetDivisors(const Way& way)
{
  const int ranks = this->Controller->GetNumberOfProcesses();
  this->GetPass()->SetNumberOfDivisors(ranks);
  std::vector<double> distances(static_cast<std::size_t>(ranks));
  std::array<double, 3> position{};
  this->Renderer->GetActiveCamera()->GetPosition(position.data());
  // Other ranks have the camera of the previous frame until this one begins.
  this->Controller->Broadcast(position.data(), 3, 0);
  vtkActor* actor = this->Renderer->GetActors()->GetLastActor();
  const double distance =
    std::sqrt(vtkMath::Distance2BetweenPoints(position.data(), actor->GetCenter()));
  this->Controller->AllGather(&distance, distances.data(), 1);
  std::vector<double> sorted = distances;
  std::sort(sorted.begin(), sorted.end());
  for (int rank = 0; rank < ranks; ++rank)
  {
    const bool isNear = way.HasBackground &&
      distances[static_cast<std::size_t>(rank)] < sorted[static_cast<std::size_t>(ranks / 2)];
    this->GetPass()->SetDivisor(rank, isNear ? 1 : way.Divisor);
  }
}
