// SPDX-License-Identifier: BSD-3-Clause
#ifndef PatientMpi_h
#define PatientMpi_h

/**
 * Whether ranks that wait for messages sleep meanwhile; off to begin with. MPI spins: where there
 * are more ranks than cores, those that wait take the time of those that work, which they do not
 * where each has a core of its own. Counts for all calls of the program and its libraries, of VTK's
 * and IceT's alike.
 *
 * By MPI's profiling interface: the program's calls stand before the library's.
 */
void WaitPatiently(bool isPatient);

#endif
