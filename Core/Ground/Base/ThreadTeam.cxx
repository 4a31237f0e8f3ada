// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/ThreadTeam.h"

namespace isosurface
{
namespace
{

thread_local ThreadTeam* CurrentTeam = nullptr;

} // namespace

ThreadTeam::ThreadTeam()
{
  if (!CurrentTeam)
  {
    CurrentTeam = this;
  }
}

ThreadTeam::~ThreadTeam()
{
  if (CurrentTeam == this)
  {
    CurrentTeam = nullptr;
  }
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->HasEnded = true;
  }
  this->Changed.notify_all();
  for (std::thread& thread : this->Threads)
  {
    thread.join();
  }
}

ThreadTeam* ThreadTeam::OfThisThread()
{
  return CurrentTeam;
}

void ThreadTeam::Run(std::function<void()> work)
{
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    if (this->Idle <= this->Waiting.size())
    {
      this->Threads.emplace_back([this] { this->Serve(); });
    }
    this->Waiting.push_back(std::move(work));
  }
  this->Changed.notify_one();
}

void ThreadTeam::Serve()
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  for (;;)
  {
    ++this->Idle;
    this->Changed.wait(lock, [&] { return this->HasEnded || !this->Waiting.empty(); });
    --this->Idle;
    if (this->Waiting.empty())
    {
      return;
    }
    const std::function<void()> work = std::move(this->Waiting.front());
    this->Waiting.pop_front();
    lock.unlock();
    work();
    lock.lock();
  }
}

} // namespace isosurface
