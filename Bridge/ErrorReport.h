// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ErrorReport_h
#define isosurface_ErrorReport_h

#include "IsosurfaceBridgeModule.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"

#include <string>

class vtkAlgorithm;
class vtkInformation;
class vtkInformationVector;

namespace isosurface
{

/**
 * Tells the pipeline that an algorithm, which has reported an error, has no output. Call it just before
 * RequestData returns 0. Then the executive does not report the failure in words of its own, with the
 * whole request; the next update executes the algorithm again, and reports the error again; and what
 * was made of an earlier output, up to ParaView's views, is empty. output: what RequestData was given,
 * also through vtkFileSeriesReader.
 */
ISOSURFACEBRIDGE_EXPORT void MarkFailure(vtkInformationVector* output);

/// Reports an error of an algorithm in the words of its message, once: vtkErrorMacro and MarkFailure.
ISOSURFACEBRIDGE_EXPORT void ReportError(
  vtkAlgorithm* algorithm, vtkInformationVector* output, const Status& error);

/// Shows `warning`, which all ranks know, on rank 0, unless it is empty or there is an error, which
/// says more.
ISOSURFACEBRIDGE_EXPORT void ReportWarning(vtkAlgorithm* algorithm, const Communicator& ranks,
  const Status& status, const std::string& warning);

/// The vtkErrorCode of an error: OutOfDiskSpaceError, or UnknownError.
ISOSURFACEBRIDGE_EXPORT unsigned long FindErrorCode(const Status& error);

/// Whether an algorithm, or since VTK 9.2 one before it in the pipeline, has been told to stop.
ISOSURFACEBRIDGE_EXPORT bool IsAborted(vtkAlgorithm& algorithm);

/// How the executions of all ranks have ended. That one was told to stop outweighs an error, such as that of a reader
/// that was stopped before it had a volume. Collective.
ISOSURFACEBRIDGE_EXPORT Status AgreeOnEnd(
  vtkAlgorithm& algorithm, Communicator& ranks, const Status& mine);

/// Tells observers of an algorithm how far it is, from `first` to `last`, and Core whether it goes
/// on.
ISOSURFACEBRIDGE_EXPORT Progress MakeProgress(
  vtkAlgorithm& algorithm, double first = 0, double last = 1);

/// Tells the pipeline that an algorithm has stopped, on ranks that were not told to stop, too: since
/// VTK 9.2 what has stopped executes at the next update, which all ranks have to do together. Call
/// it before RequestData returns 1, on all ranks.
ISOSURFACEBRIDGE_EXPORT void MarkAborted(vtkAlgorithm& algorithm);

/// What RequestData returns once all ranks have agreed on how it ended: 1 if it is done or was
/// stopped, which is marked; 0 after an error, which is reported. Empties the outputs unless it is done.
ISOSURFACEBRIDGE_EXPORT int EndExecution(
  vtkAlgorithm* algorithm, vtkInformationVector* output, const Status& status);

/// Lets `algorithm`, which takes no data of its input, execute although the input was stopped once.
ISOSURFACEBRIDGE_EXPORT void IgnoreAbortedInput(vtkAlgorithm& algorithm);

/// Whether the filter that gives the input has stopped. Always false before VTK 9.2.
ISOSURFACEBRIDGE_EXPORT bool IsInputAborted(vtkInformation* input);

} // namespace isosurface

#endif
