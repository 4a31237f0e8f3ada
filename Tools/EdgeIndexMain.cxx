// SPDX-License-Identifier: BSD-3-Clause
// edgeindex: prints and checks edge-index files, and decodes them to triangles.
#include "EdgeIndexCommands.h"
#include "EdgeIndexOptions.h"
#include "StopSignal.h"

#include "vtkLogger.h"

#include "Ground/Base/PrintableText.h"

#include <cstdio>
#include <exception>
#include <new>

using namespace isosurface;

namespace
{

using Command = EdgeIndexOptions::Command;

Status Run(const Result<EdgeIndexOptions>& options)
{
  ISOSURFACE_RETURN_IF_ERROR(options.GetStatus());
  switch (options->What)
  {
    case Command::Info:
      return RunEdgeIndexInfo(*options);
    case Command::Verify:
      return RunEdgeIndexVerify(*options);
    case Command::Decode:
      return RunEdgeIndexDecode(*options);
    default:
      std::fputs(options->Text.c_str(), stdout);
      return Status::Ok();
  }
}

int Fail(const char* reason)
{
  std::fprintf(stderr, "edgeindex: %s\n", MakePrintable(reason).c_str());
  return 1;
}

} // namespace

int main(int argc, char** argv)
{
  OpenStandardStreams();
  CatchStopSignals("edgeindex");
  // Errors of VTK's writers are printed in one line, like all others.
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  try
  {
    Status status = Run(EdgeIndexOptions::Parse(argc, argv));
    status = status.IsOk() ? FlushStandardOutput() : status;
    if (status.IsOk())
    {
      return 0;
    }
    Fail(status.GetMessage().c_str());
    return status.GetCode() == StatusCode::Aborted ? 130 : 1;
  }
  catch (const std::bad_alloc&)
  {
    return Fail("out of memory; all formats take less than .vtp, with a smaller --memory still "
                "less");
  }
  catch (const std::exception& error)
  {
    return Fail(error.what());
  }
}
