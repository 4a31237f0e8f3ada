// SPDX-License-Identifier: BSD-3-Clause
#ifndef PatientMpi_h
#define PatientMpi_h

/**
 * Makes ranks sleep while they wait for messages; off by default. MPI spins: where there are more
 * ranks than cores, waiting ranks take processor time from working ones. Affects all calls of the
 * program and its libraries, those of VTK and IceT included.
 *
 * Implemented with MPI's profiling interface: the program's definitions replace the library's.
 */
void WaitPatiently(bool isPatient);

#endif
