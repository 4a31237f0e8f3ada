// SPDX-License-Identifier: BSD-3-Clause
// Runs the tests on all ranks at once; fails if one rank fails. Rank 0 tells of the tests, the
// others of failures alone.
#include "vtkCommunicator.h"
#include "vtkLogger.h"
#include "vtkMPIController.h"
#include "vtkNew.h"

#include <gtest/gtest.h>

#include <iostream>
#include <sstream>

namespace
{

class FailurePrinter : public testing::EmptyTestEventListener
{
public:
  explicit FailurePrinter(int rank)
    : Rank(rank)
  {
  }

private:
  void OnTestPartResult(const testing::TestPartResult& result) override
  {
    if (result.failed())
    {
      std::ostringstream text;
      text << "rank " << this->Rank << ": " << result << "\n";
      std::cerr << text.str();
    }
  }

  int Rank;
};

} // namespace

int main(int argc, char** argv)
{
  vtkNew<vtkMPIController> controller;
  controller->Initialize(&argc, &argv);
  vtkMultiProcessController::SetGlobalController(controller);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_WARNING);

  testing::InitGoogleTest(&argc, argv);
  const int rank = controller->GetLocalProcessId();
  if (rank != 0)
  {
    testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new FailurePrinter(rank));
  }
  const int mine = RUN_ALL_TESTS();
  int worst = 0;
  controller->AllReduce(&mine, &worst, 1, vtkCommunicator::MAX_OP);
  vtkMultiProcessController::SetGlobalController(nullptr);
  controller->Finalize();
  return worst;
}
