// SPDX-License-Identifier: BSD-3-Clause
#include "ErrorReport.h"

#include "vtkAlgorithm.h"
#include "vtkCommand.h"
#include "vtkDataObject.h"
#include "vtkDemandDrivenPipeline.h"
#include "vtkErrorCode.h"
#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"
#include "vtkInformationExecutivePortVectorKey.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkOutputWindow.h"
#include "vtkVersionMacros.h"

#include "Ground/Base/PrintableText.h"

namespace isosurface
{
namespace
{

/// What vtkExecutive::CallAlgorithm says of an algorithm that has failed.
constexpr const char* FailureWords = "returned failure for request";

/// Takes the next error of an executive in place of the output window, and passes it on to that
/// unless it is a failure that was reported.
class FailureSilencer : public vtkCommand
{
public:
  static FailureSilencer* New() { return new FailureSilencer; }
  vtkTypeMacro(FailureSilencer, vtkCommand);

  void Execute(vtkObject* executive, unsigned long, void* text) override
  {
    executive->RemoveObserver(this);
    const char* message = static_cast<const char*>(text);
    if (std::string(message).find(FailureWords) == std::string::npos)
    {
      vtkOutputWindow::GetInstance()->DisplayErrorText(message);
    }
  }
};

/// Has a consumer without outputs, which an executive does not execute behind a failure, take its empty
/// input. Writers keep what they have written.
void ShowNothing(vtkExecutive* consumer)
{
  vtkAlgorithm* representation = consumer->GetAlgorithm();
  // By name: ParaView's representations, which this module does without.
  if (representation->IsA("vtkDataRepresentation"))
  {
    vtkNew<vtkInformation> request;
    request->Set(vtkDemandDrivenPipeline::REQUEST_DATA());
    representation->ProcessRequest(
      request, consumer->GetInputInformation(), consumer->GetOutputInformation());
    // Its proxy waits for that, and is told of no change until then.
    representation->InvokeEvent(vtkCommand::UpdateDataEvent);
  }
}

/// Empties what was made of an output before: nothing behind a failure is executed, and it would stay.
void EmptyConsumers(vtkInformation* outInfo)
{
  const int count = vtkExecutive::CONSUMERS()->Length(outInfo);
  for (int number = 0; number < count; ++number)
  {
    vtkExecutive* consumer = vtkExecutive::CONSUMERS()->GetExecutives(outInfo)[number];
    vtkInformationVector* made = consumer ? consumer->GetOutputInformation() : nullptr;
    for (int port = 0; made && port < made->GetNumberOfInformationObjects(); ++port)
    {
      vtkInformation* info = made->GetInformationObject(port);
      if (vtkDataObject* data = vtkDataObject::GetData(info))
      {
        data->Initialize();
      }
      EmptyConsumers(info);
    }
    if (made && made->GetNumberOfInformationObjects() == 0)
    {
      ShowNothing(consumer);
    }
  }
}

} // namespace

void MarkFailure(vtkInformationVector* output)
{
  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(output->GetInformationObject(0));
  if (executive && vtkObject::GetGlobalWarningDisplay())
  {
    vtkNew<FailureSilencer> silencer;
    executive->AddObserver(vtkCommand::ErrorEvent, silencer);
  }
  for (int port = 0; port < output->GetNumberOfInformationObjects(); ++port)
  {
    vtkInformation* info = output->GetInformationObject(port);
    info->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
    EmptyConsumers(info);
  }
}

void ReportError(vtkAlgorithm* algorithm, vtkInformationVector* output, const Status& error)
{
  vtkErrorWithObjectMacro(algorithm, << MakePrintable(error.GetMessage()));
  MarkFailure(output);
}

void ReportWarning(vtkAlgorithm* algorithm, const Communicator& ranks, const Status& status,
  const std::string& warning)
{
  if (status.IsOk() && !warning.empty() && ranks.GetRank() == 0)
  {
    vtkWarningWithObjectMacro(algorithm, << warning);
  }
}

unsigned long FindErrorCode(const Status& error)
{
  return error.GetCode() == StatusCode::DiskFull ? vtkErrorCode::OutOfDiskSpaceError
                                                 : vtkErrorCode::UnknownError;
}

bool IsAborted(vtkAlgorithm& algorithm)
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0)
  return algorithm.CheckAbort();
#else
  return algorithm.GetAbortExecute() != 0;
#endif
}

Status AgreeOnEnd(vtkAlgorithm& algorithm, Communicator& ranks, const Status& mine)
{
  return ranks.Agree(
    IsAborted(algorithm) ? Status(StatusCode::Aborted, "the execution was aborted") : mine);
}

Progress MakeProgress(vtkAlgorithm& algorithm, double first, double last)
{
  return [&algorithm, first, last](double share)
  {
    algorithm.UpdateProgress(first + share * (last - first));
    return !IsAborted(algorithm);
  };
}

void MarkAborted(vtkAlgorithm& algorithm)
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0)
  algorithm.SetAbortOutput(true);
#else
  static_cast<void>(algorithm);
#endif
}

int EndExecution(vtkAlgorithm* algorithm, vtkInformationVector* output, const Status& status)
{
  for (int port = 0; !status.IsOk() && port < output->GetNumberOfInformationObjects(); ++port)
  {
    vtkDataObject::GetData(output, port)->Initialize();
  }
  if (status.GetCode() == StatusCode::Aborted)
  {
    MarkAborted(*algorithm);
    return 1;
  }
  if (!status.IsOk())
  {
    ReportError(algorithm, output, status);
    return 0;
  }
  return 1;
}

void IgnoreAbortedInput(vtkAlgorithm& algorithm)
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0)
  algorithm.SetAbortOutput(false);
#else
  static_cast<void>(algorithm);
#endif
}

bool IsInputAborted(vtkInformation* input)
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0)
  return input->Get(vtkAlgorithm::ABORTED()) != 0;
#else
  static_cast<void>(input);
  return false;
#endif
}

} // namespace isosurface
