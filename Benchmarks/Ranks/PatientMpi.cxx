// SPDX-License-Identifier: BSD-3-Clause
#include "PatientMpi.h"

#include <mpi.h>

#include <chrono>
#include <thread>

namespace
{

bool IsPatient = false;

// Calls test(done) until it is done or fails; sleeps in between, longer after many calls.
template <typename Function>
int Await(const Function& test)
{
  constexpr int Eager = 10;
  constexpr int Brief = 40;
  int done = 0;
  int status = test(done);
  for (int attempt = 0; status == MPI_SUCCESS && done == 0; ++attempt)
  {
    if (attempt > Eager)
    {
      std::this_thread::sleep_for(std::chrono::microseconds(attempt > Brief ? 200 : 50));
    }
    status = test(done);
  }
  return status;
}

// Waits for the request that was begun with the status `begun`.
int Finish(int begun, MPI_Request& request, MPI_Status* status = MPI_STATUS_IGNORE)
{
  return begun == MPI_SUCCESS ? Await([&](int& done) { return PMPI_Test(&request, &done, status); })
                              : begun;
}

} // namespace

void WaitPatiently(bool isPatient)
{
  IsPatient = isPatient;
}

extern "C"
{

  int MPI_Wait(MPI_Request* request, MPI_Status* status)
  {
    return IsPatient ? Finish(MPI_SUCCESS, *request, status) : PMPI_Wait(request, status);
  }

  int MPI_Waitall(int count, MPI_Request* requests, MPI_Status* statuses)
  {
    return IsPatient
      ? Await([&](int& done) { return PMPI_Testall(count, requests, &done, statuses); })
      : PMPI_Waitall(count, requests, statuses);
  }

  int MPI_Waitany(int count, MPI_Request* requests, int* index, MPI_Status* status)
  {
    return IsPatient
      ? Await([&](int& done) { return PMPI_Testany(count, requests, index, &done, status); })
      : PMPI_Waitany(count, requests, index, status);
  }

  int MPI_Recv(void* buffer, int count, MPI_Datatype type, int source, int tag, MPI_Comm ranks,
    MPI_Status* status)
  {
    MPI_Request request{};
    return IsPatient
      ? Finish(PMPI_Irecv(buffer, count, type, source, tag, ranks, &request), request, status)
      : PMPI_Recv(buffer, count, type, source, tag, ranks, status);
  }

  int MPI_Send(
    const void* buffer, int count, MPI_Datatype type, int target, int tag, MPI_Comm ranks)
  {
    MPI_Request request{};
    return IsPatient
      ? Finish(PMPI_Isend(buffer, count, type, target, tag, ranks, &request), request)
      : PMPI_Send(buffer, count, type, target, tag, ranks);
  }

  int MPI_Sendrecv(const void* sent, int sentCount, MPI_Datatype sentType, int target, int sentTag,
    void* received, int count, MPI_Datatype type, int source, int tag, MPI_Comm ranks,
    MPI_Status* status)
  {
    if (!IsPatient)
    {
      return PMPI_Sendrecv(sent, sentCount, sentType, target, sentTag, received, count, type,
        source, tag, ranks, status);
    }
    MPI_Request receiving{};
    const int begun = PMPI_Irecv(received, count, type, source, tag, ranks, &receiving);
    const int isSent = MPI_Send(sent, sentCount, sentType, target, sentTag, ranks);
    const int isReceived = Finish(begun, receiving, status);
    return isSent != MPI_SUCCESS ? isSent : isReceived;
  }

  int MPI_Barrier(MPI_Comm ranks)
  {
    MPI_Request request{};
    return IsPatient ? Finish(PMPI_Ibarrier(ranks, &request), request) : PMPI_Barrier(ranks);
  }

  int MPI_Bcast(void* buffer, int count, MPI_Datatype type, int root, MPI_Comm ranks)
  {
    MPI_Request request{};
    return IsPatient ? Finish(PMPI_Ibcast(buffer, count, type, root, ranks, &request), request)
                     : PMPI_Bcast(buffer, count, type, root, ranks);
  }

  int MPI_Allreduce(
    const void* mine, void* all, int count, MPI_Datatype type, MPI_Op operation, MPI_Comm ranks)
  {
    MPI_Request request{};
    return IsPatient
      ? Finish(PMPI_Iallreduce(mine, all, count, type, operation, ranks, &request), request)
      : PMPI_Allreduce(mine, all, count, type, operation, ranks);
  }

  int MPI_Allgather(const void* mine, int count, MPI_Datatype type, void* all, int allCount,
    MPI_Datatype allType, MPI_Comm ranks)
  {
    MPI_Request request{};
    return IsPatient
      ? Finish(PMPI_Iallgather(mine, count, type, all, allCount, allType, ranks, &request), request)
      : PMPI_Allgather(mine, count, type, all, allCount, allType, ranks);
  }

  int MPI_Allgatherv(const void* mine, int count, MPI_Datatype type, void* all, const int* counts,
    const int* offsets, MPI_Datatype allType, MPI_Comm ranks)
  {
    MPI_Request request{};
    return IsPatient
      ? Finish(PMPI_Iallgatherv(mine, count, type, all, counts, offsets, allType, ranks, &request),
          request)
      : PMPI_Allgatherv(mine, count, type, all, counts, offsets, allType, ranks);
  }

  int MPI_Gather(const void* mine, int count, MPI_Datatype type, void* all, int allCount,
    MPI_Datatype allType, int root, MPI_Comm ranks)
  {
    MPI_Request request{};
    return IsPatient
      ? Finish(
          PMPI_Igather(mine, count, type, all, allCount, allType, root, ranks, &request), request)
      : PMPI_Gather(mine, count, type, all, allCount, allType, root, ranks);
  }

  int MPI_Gatherv(const void* mine, int count, MPI_Datatype type, void* all, const int* counts,
    const int* offsets, MPI_Datatype allType, int root, MPI_Comm ranks)
  {
    MPI_Request request{};
    return IsPatient ? Finish(PMPI_Igatherv(mine, count, type, all, counts, offsets, allType, root,
                                ranks, &request),
                         request)
                     : PMPI_Gatherv(mine, count, type, all, counts, offsets, allType, root, ranks);
  }

} // extern "C"
