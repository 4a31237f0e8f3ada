// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Address.h"

#include "Ground/Base/FileSystem.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <initializer_list>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace isosurface
{
namespace
{

bool BeginsWith(const std::string& text, const char* start)
{
  return text.compare(0, std::strlen(start), start) == 0;
}

/// The first of these variables that has a value.
std::string GetVariable(std::initializer_list<const char*> names)
{
  for (const char* const name : names)
  {
    const char* const value =
      std::getenv(name); // NOLINT(concurrency-mt-unsafe): nobody sets it meanwhile
    if (value && *value)
    {
      return value;
    }
  }
  return {};
}

std::string Trim(const std::string& text)
{
  const std::size_t begin = text.find_first_not_of(" \t\r");
  return begin == std::string::npos
    ? std::string()
    : text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

/// A value of a section of one of Amazon's files, ~/.aws/NAME or where the variable says.
std::string FindInFile(
  const char* variable, const char* name, const std::string& section, const char* wanted)
{
  const std::string chosen = GetVariable({ variable });
  std::ifstream file(chosen.empty() ? GetVariable({ "HOME" }) + "/.aws/" + name : chosen);
  bool isMine = false;
  for (std::string line; std::getline(file, line);)
  {
    line = Trim(line);
    const std::size_t equals = line.find('=');
    if (!line.empty() && line[0] == '[')
    {
      isMine = Trim(line.substr(1, line.find(']') - 1)) == section;
    }
    else if (isMine && equals != std::string::npos && Trim(line.substr(0, equals)) == wanted)
    {
      return Trim(line.substr(equals + 1));
    }
  }
  return {};
}

std::string FindInConfig(const std::string& profile, const char* wanted)
{
  return FindInFile(
    "AWS_CONFIG_FILE", "config", profile == "default" ? profile : "profile " + profile, wanted);
}

void TakeKeys(const std::string& profile, AddressTarget& target)
{
  target.Key = GetVariable({ "AWS_ACCESS_KEY_ID" });
  target.Secret = GetVariable({ "AWS_SECRET_ACCESS_KEY" });
  target.Token = GetVariable({ "AWS_SESSION_TOKEN" });
  if (target.Key.empty() || target.Secret.empty())
  {
    const auto find = [&profile](const char* wanted)
    { return FindInFile("AWS_SHARED_CREDENTIALS_FILE", "credentials", profile, wanted); };
    target.Key = find("aws_access_key_id");
    target.Secret = find("aws_secret_access_key");
    target.Token = find("aws_session_token");
  }
}

bool IsPrivateFour(std::uint32_t address)
{
  const auto isIn = [address](std::uint32_t net, int bits)
  { return (address ^ net) >> (32 - bits) == 0; };
  return isIn(0, 8) || isIn(0x0a000000, 8) || isIn(0x7f000000, 8) || isIn(0xa9fe0000, 16) ||
    isIn(0xac100000, 12) || isIn(0xc0a80000, 16) || isIn(0x64400000, 10);
}

bool IsPrivateSix(const in6_addr& address)
{
  const std::uint8_t* const bytes = address.s6_addr;
  if (IN6_IS_ADDR_V4MAPPED(&address))
  {
    std::uint32_t four = 0;
    std::memcpy(&four, bytes + 12, sizeof(four));
    return IsPrivateFour(ntohl(four));
  }
  return IN6_IS_ADDR_LOOPBACK(&address) || IN6_IS_ADDR_UNSPECIFIED(&address) ||
    (bytes[0] & 0xfe) == 0xfc || (bytes[0] == 0xfe && (bytes[1] & 0xc0) == 0x80);
}

/// A key of S3 as a URL has it.
std::string EncodeKey(const std::string& key)
{
  const std::string plain = "-_.~/";
  const char* const digits = "0123456789ABCDEF";
  std::string encoded;
  for (const char letter : key)
  {
    const auto byte = static_cast<unsigned char>(letter);
    const bool isPlain =
      (byte < 128 && std::isalnum(byte)) || plain.find(letter) != std::string::npos;
    encoded +=
      isPlain ? std::string(1, letter) : std::string{ '%', digits[byte >> 4], digits[byte & 15] };
  }
  return encoded;
}

} // namespace

bool IsAddress(const std::string& path)
{
  return BeginsWith(path, "http://") || BeginsWith(path, "https://") || BeginsWith(path, "s3://");
}

int ChooseReadingThreads(const std::string& path, int threads)
{
  constexpr int many = 16;
  return IsAddress(path) ? std::max(many, threads) : threads;
}

Result<AddressTarget> FindAddressTarget(const std::string& address, const std::string& region)
{
  const auto refuse = [&address](const char* reason) {
    return Status(StatusCode::InvalidArgument, HideQuery(address) + ": cannot be read: " + reason);
  };
  const std::size_t begin = address.find("://") + 3;
  const std::string host = address.substr(begin, address.find('/', begin) - begin);
  if (host.find('@') != std::string::npos)
  {
    return Status(StatusCode::InvalidArgument,
      address.substr(0, begin) + host.substr(host.rfind('@') + 1) +
        ": an address with a password is not read");
  }
  const bool isBucket = BeginsWith(address, "s3://");
  const auto isWrong = [isBucket](char letter)
  {
    const auto code = static_cast<unsigned char>(letter);
    return code < ' ' || code == 127 || (code == ' ' && !isBucket);
  };
  if (host.empty() || std::any_of(address.begin(), address.end(), isWrong))
  {
    return refuse("it is no address");
  }
  if (!isBucket)
  {
    return address.find_first_of("?#") != std::string::npos
      ? Result<AddressTarget>(refuse("an address with a query or a fragment names no file"))
      : AddressTarget{ address, {}, {}, {}, {} };
  }
  const std::string chosen = GetVariable({ "AWS_PROFILE" });
  const std::string profile = chosen.empty() ? "default" : chosen;
  AddressTarget target;
  TakeKeys(profile, target);
  std::string known = region.empty() ? GetVariable({ "AWS_REGION", "AWS_DEFAULT_REGION" }) : region;
  known = known.empty() ? FindInConfig(profile, "region") : known;
  target.Region = known.empty() ? "us-east-1" : known;
  std::string endpoint = GetVariable({ "AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL" });
  endpoint = endpoint.empty() ? FindInConfig(profile, "endpoint_url") : endpoint;
  const std::size_t slash = address.find('/', begin);
  const std::string key = slash == std::string::npos ? "/" : EncodeKey(address.substr(slash));
  if (!endpoint.empty())
  {
    endpoint.erase(endpoint.find_last_not_of('/') + 1);
    target.Url =
      (endpoint.find("://") == std::string::npos ? "https://" : "") + endpoint + "/" + host + key;
    return target;
  }
  // A certificate of Amazon is of no bucket with points.
  const std::string server = known.empty() ? "s3.amazonaws.com" : "s3." + known + ".amazonaws.com";
  target.Url = host.find('.') == std::string::npos ? "https://" + host + "." + server + key
                                                   : "https://" + server + "/" + host + key;
  return target;
}

std::string FindHost(const std::string& url)
{
  return url.substr(0, url.find('/', std::min(url.size(), url.find("://") + 3)));
}

std::string HideQuery(const std::string& url)
{
  return url.substr(0, url.find_first_of("?#"));
}

bool IsPrivateAddress(const sockaddr& address)
{
  if (address.sa_family == AF_INET)
  {
    sockaddr_in four = {};
    std::memcpy(&four, &address, sizeof(four));
    return IsPrivateFour(ntohl(four.sin_addr.s_addr));
  }
  if (address.sa_family == AF_INET6)
  {
    sockaddr_in6 six = {};
    std::memcpy(&six, &address, sizeof(six));
    return IsPrivateSix(six.sin6_addr);
  }
  return true;
}

bool IsPrivateAddress(const std::string& text)
{
  in_addr four = {};
  in6_addr six = {};
  return (::inet_pton(AF_INET, text.c_str(), &four) == 1 && IsPrivateFour(ntohl(four.s_addr))) ||
    (::inet_pton(AF_INET6, text.c_str(), &six) == 1 && IsPrivateSix(six));
}

} // namespace isosurface
