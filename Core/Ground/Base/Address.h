// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Address_h
#define isosurface_Address_h

#include "Ground/Base/Status.h"

#include <string>

struct sockaddr;

namespace isosurface
{

/// What asks a server for an object: its URL, and for s3:// the keys that sign the request, if there are any.
struct AddressTarget
{
  std::string Url;
  std::string Key;
  std::string Secret;
  std::string Token;
  std::string Region; ///< empty: not of s3://
};

/**
 * The object of an address. s3://BUCKET/KEY is asked of AWS_ENDPOINT_URL_S3 or AWS_ENDPOINT_URL, otherwise of
 * Amazon; keys and the region are those of the variables AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY,
 * AWS_SESSION_TOKEN, AWS_REGION (or AWS_DEFAULT_REGION) and AWS_PROFILE, or of ~/.aws. `region`: which the
 * server says it has; perhaps empty. Error: InvalidArgument, for an address with a password, a query or a
 * fragment, too.
 */
Result<AddressTarget> FindAddressTarget(const std::string& address, const std::string& region);

/// "https://host:port" of a URL.
std::string FindHost(const std::string& url);
/// A URL without a query, which may have a key, for messages.
std::string HideQuery(const std::string& url);

/// Whether only this machine or its network has the address.
bool IsPrivateAddress(const sockaddr& address);
/// The same of the text of an IP address; false of other texts.
bool IsPrivateAddress(const std::string& text);

} // namespace isosurface

#endif
