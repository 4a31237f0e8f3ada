// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EventCounter_h
#define isosurface_EventCounter_h

#include "vtkAlgorithm.h"
#include "vtkCommand.h"
#include "vtkObject.h"
#include "vtkSmartPointer.h"

#include <functional>
#include <utility>
#include <vector>

namespace isosurface
{

/// Counts an event of an object. An algorithm's StartEvent tells that it makes new data.
class EventCounter
{
public:
  EventCounter(vtkObject* object, unsigned long event)
    : Object(object)
    , Tag(object->AddObserver(event, this, &EventCounter::Add))
  {
  }
  ~EventCounter() { this->Object->RemoveObserver(this->Tag); }
  EventCounter(const EventCounter&) = delete;
  EventCounter& operator=(const EventCounter&) = delete;

  int Count = 0;

private:
  void Add() { ++this->Count; }

  vtkSmartPointer<vtkObject> Object;
  unsigned long Tag;
};

/// Keeps what an algorithm tells of its progress; calls a function after each.
class ProgressKeeper
{
public:
  explicit ProgressKeeper(vtkObject* object, std::function<void(double)> then = {})
    : Object(object)
    , Tag(object->AddObserver(vtkCommand::ProgressEvent, this, &ProgressKeeper::Keep))
    , Then(std::move(then))
  {
  }
  ~ProgressKeeper() { this->Object->RemoveObserver(this->Tag); }
  ProgressKeeper(const ProgressKeeper&) = delete;
  ProgressKeeper& operator=(const ProgressKeeper&) = delete;

  /// Whether shares begin at 0 or more, grow, and end at 1.
  bool IsRising() const
  {
    bool isRising = !this->Shares.empty() && this->Shares.front() >= 0 && this->Shares.back() == 1;
    for (std::size_t index = 1; index < this->Shares.size(); ++index)
    {
      isRising = isRising && this->Shares[index - 1] <= this->Shares[index];
    }
    return isRising;
  }

  std::vector<double> Shares;

private:
  void Keep(vtkObject*, unsigned long, void* share)
  {
    this->Shares.push_back(*static_cast<double*>(share));
    if (this->Then)
    {
      this->Then(this->Shares.back());
    }
  }

  vtkSmartPointer<vtkObject> Object;
  unsigned long Tag;
  std::function<void(double)> Then;
};

/// For a ProgressKeeper: stops an algorithm at the first share above this one.
inline std::function<void(double)> StopAbove(vtkAlgorithm* algorithm, double share)
{
  return [algorithm, share](double done)
  {
    if (done > share && done < 1)
    {
      algorithm->SetAbortExecute(1);
    }
  };
}

} // namespace isosurface

#endif
