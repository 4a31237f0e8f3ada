// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CurlLibrary_h
#define isosurface_CurlLibrary_h

#include "Ground/Base/Status.h"

#include <ctime>
#include <string>

#include <sys/socket.h>

namespace isosurface
{

/**
 * What is used of libcurl, which is loaded with the first address: so nothing is linked with it, neither its
 * OpenSSL nor its GnuTLS flavour. The numbers are those of its interface, which no release of
 * libcurl.so.4 changes (curl/curl.h, curl/multi.h); a test compares them with the headers.
 */
struct CurlLibrary
{
  enum Option : int
  {
    ErrorBuffer = 10010,
    Url = 10002,
    RangeOfBytes = 10007,
    WriteFunction = 20011,
    WriteData = 10001,
    LowSpeedLimit = 19,
    LowSpeedTime = 20,
    HttpHeader = 10023,
    HeaderData = 10029,
    HeaderFunction = 20079,
    ConnectTimeout = 78,
    NoSignal = 99,
    Certificates = 10065,
    OpenSocketFunction = 20163,
    OpenSocketData = 10164,
    UserName = 10173,
    Password = 10174,
    Protocols = 181,
    PipeWait = 237,
    UserAgent = 10018,
    SignatureV4 = 10305 ///< since 7.75
  };
  enum MultiOption : int
  {
    MaximumHostConnections = 7,
    MaximumConnections = 6
  };
  enum Information : int
  {
    ResponseCode = 0x200002,
    RedirectUrl = 0x10001f,
    PrimaryIp = 0x100020
  };
  enum Code : int
  {
    UnknownHost = 6,
    PartialBody = 18,
    WriteError = 23,
    TimedOut = 28,
    UntrustedServer = 60
  };
  static constexpr int MessageDone = 1;
  static constexpr long HttpAndHttps = 3;

  struct Message
  {
    int Kind;
    void* Easy;
    union
    {
      void* Whatever;
      int Result;
    } Data;
  };
  struct SocketAddress
  {
    int Family;
    int Type;
    int Protocol;
    unsigned int Length;
    sockaddr Address;
  };

  int (*GlobalInit)(long) = nullptr;
  char* (*Version)() = nullptr;
  std::time_t (*GetDate)(const char*, const std::time_t*) = nullptr;
  void* (*EasyInit)() = nullptr;
  void (*EasyCleanup)(void*) = nullptr;
  int (*EasySetOption)(void*, int, ...) = nullptr;
  int (*EasyGetInformation)(void*, int, ...) = nullptr;
  const char* (*EasyError)(int) = nullptr;
  void* (*ListAppend)(void*, const char*) = nullptr;
  void (*ListFree)(void*) = nullptr;
  void* (*MultiInit)() = nullptr;
  int (*MultiSetOption)(void*, int, ...) = nullptr;
  int (*MultiAdd)(void*, void*) = nullptr;
  int (*MultiRemove)(void*, void*) = nullptr;
  int (*MultiPerform)(void*, int*) = nullptr;
  int (*MultiPoll)(void*, void*, unsigned int, int, int*) = nullptr; ///< since 7.66
  int (*MultiWakeUp)(void*) = nullptr;                               ///< since 7.68
  Message* (*MultiRead)(void*, int*) = nullptr;

  /// Loads it; it stays loaded. Unsupported: a sentence without an address.
  static Result<const CurlLibrary*> Load();
};

} // namespace isosurface

#endif
