// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Address.h"

#include "Ground/Base/CurlLibrary.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/HttpTransfers.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <utility>

#if __has_include(<curl/curl.h>)
#  include <curl/curl.h>
#endif

using namespace isosurface;

namespace
{

#if __has_include(<curl/curl.h>)
using Curl = CurlLibrary;

constexpr std::pair<int, int> OursAndTheirs[] = {
  { Curl::Url, CURLOPT_URL },
  { Curl::RangeOfBytes, CURLOPT_RANGE },
  { Curl::ErrorBuffer, CURLOPT_ERRORBUFFER },
  { Curl::WriteFunction, CURLOPT_WRITEFUNCTION },
  { Curl::WriteData, CURLOPT_WRITEDATA },
  { Curl::LowSpeedLimit, CURLOPT_LOW_SPEED_LIMIT },
  { Curl::LowSpeedTime, CURLOPT_LOW_SPEED_TIME },
  { Curl::HttpHeader, CURLOPT_HTTPHEADER },
  { Curl::HeaderData, CURLOPT_HEADERDATA },
  { Curl::HeaderFunction, CURLOPT_HEADERFUNCTION },
  { Curl::ConnectTimeout, CURLOPT_CONNECTTIMEOUT },
  { Curl::NoSignal, CURLOPT_NOSIGNAL },
  { Curl::Certificates, CURLOPT_CAINFO },
  { Curl::OpenSocketFunction, CURLOPT_OPENSOCKETFUNCTION },
  { Curl::OpenSocketData, CURLOPT_OPENSOCKETDATA },
  { Curl::UserName, CURLOPT_USERNAME },
  { Curl::Password, CURLOPT_PASSWORD },
  { Curl::PipeWait, CURLOPT_PIPEWAIT },
  { Curl::UserAgent, CURLOPT_USERAGENT },
  { Curl::MaximumHostConnections, CURLMOPT_MAX_HOST_CONNECTIONS },
  { Curl::MaximumConnections, CURLMOPT_MAXCONNECTS },
  { Curl::ResponseCode, CURLINFO_RESPONSE_CODE },
  { Curl::RedirectUrl, CURLINFO_REDIRECT_URL },
  { Curl::PrimaryIp, CURLINFO_PRIMARY_IP },
  { Curl::UnknownHost, CURLE_COULDNT_RESOLVE_HOST },
  { Curl::PartialBody, CURLE_PARTIAL_FILE },
  { Curl::WriteError, CURLE_WRITE_ERROR },
  { Curl::TimedOut, CURLE_OPERATION_TIMEDOUT },
  { Curl::UntrustedServer, CURLE_PEER_FAILED_VERIFICATION },
  { Curl::MessageDone, CURLMSG_DONE },
  { Curl::HttpAndHttps, (CURLPROTO_HTTP | CURLPROTO_HTTPS) },
#  if LIBCURL_VERSION_NUM >= 0x074b00
  { Curl::SignatureV4, CURLOPT_AWS_SIGV4 },
#  endif
};
static_assert(
  sizeof(Curl::Message) == sizeof(CURLMsg) && sizeof(Curl::SocketAddress) == sizeof(curl_sockaddr));
#endif

/// The environment that keys come from, as a test wants it.
class AddressTest : public testing::Test
{
protected:
  AddressTest()
  {
    for (const char* const name : { "AWS_ENDPOINT_URL", "AWS_ENDPOINT_URL_S3", "AWS_REGION",
           "AWS_DEFAULT_REGION", "AWS_PROFILE", "AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY" })
    {
      ::unsetenv(name);
    }
    ::setenv("AWS_CONFIG_FILE", "/dev/null", 1);
    ::setenv("AWS_SHARED_CREDENTIALS_FILE", "/dev/null", 1);
  }
  static std::string FindUrl(const std::string& address, const std::string& region = "")
  {
    const auto target = FindAddressTarget(address, region);
    return target.IsOk() ? target->Url : target.GetStatus().GetMessage();
  }
};

} // namespace

#if __has_include(<curl/curl.h>)
TEST(Addresses, AreFetchedByTheNumbersOfLibcurl)
{
  for (const auto& [ours, theirs] : OursAndTheirs)
  {
    EXPECT_EQ(ours, theirs);
  }
}
#endif

TEST(Addresses, AreThoseOfTheWebAlone)
{
  EXPECT_TRUE(
    IsAddress("http://host/a") && IsAddress("https://host/a") && IsAddress("s3://bucket/a"));
  EXPECT_FALSE(
    IsAddress("file:///etc/passwd") || IsAddress("http:/host/a") || IsAddress("a/http://b"));
}

TEST(Addresses, OfPrivateNetworksAreToldFromPublicOnes)
{
  for (const char* const text :
    { "127.0.0.1", "10.1.2.3", "172.16.0.1", "172.31.255.255", "192.168.1.1", "169.254.169.254",
      "100.64.0.1", "0.0.0.0", "::1", "fe80::1", "fd00::1", "::ffff:10.0.0.1" })
  {
    EXPECT_TRUE(IsPrivateAddress(std::string(text))) << text;
  }
  for (const char* const text : { "8.8.8.8", "172.32.0.1", "172.15.0.1", "193.62.193.81",
         "2001:4860:4860::8888", "::ffff:8.8.8.8", "x" })
  {
    EXPECT_FALSE(IsPrivateAddress(std::string(text))) << text;
  }
}

TEST(Addresses, OfPrivateNetworksAreNotReachedFromPublicServers)
{
  HttpRequest request;
  request.Target.Url = "http://127.0.0.1:9/secret";
  request.IsPublic = true; // as behind a redirection
  const auto answer = HttpTransfers::Fetch("http://public/a", request);
  EXPECT_NE(answer.GetStatus().GetMessage().find("to a private address, which is not followed"),
    std::string::npos);
}

TEST_F(AddressTest, OfBucketsAreUrlsOfTheirServer)
{
  EXPECT_EQ(FindUrl("s3://bucket/a/b.zarr"), "https://bucket.s3.amazonaws.com/a/b.zarr");
  EXPECT_EQ(FindUrl("s3://my.bucket/a"), "https://s3.amazonaws.com/my.bucket/a");
  EXPECT_EQ(FindUrl("s3://bucket/a b+c", "eu-west-2"),
    "https://bucket.s3.eu-west-2.amazonaws.com/a%20b%2Bc");
  ::setenv("AWS_ENDPOINT_URL", "https://s3.example.org/", 1);
  EXPECT_EQ(FindUrl("s3://bucket/a"), "https://s3.example.org/bucket/a");
  ::setenv("AWS_ENDPOINT_URL_S3", "http://127.0.0.1:9000", 1);
  EXPECT_EQ(FindUrl("s3://bucket/a"), "http://127.0.0.1:9000/bucket/a");
}
