// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Status.h"
#include "Fixtures/Require.h"
#include "Ground/Base/DescriptorPool.h"
#include "Ground/Base/PrintableText.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <new>
#include <system_error>

using namespace isosurface;

namespace
{

// The error of a step that throws.
template <typename Step>
Status Catch(const Step& step)
{
  try
  {
    step();
  }
  catch (const std::exception& exception)
  {
    return MakeExceptionError("a.bvol", exception);
  }
  return Status::Ok();
}

TEST(Status, ShortMemoryIsNotTakenForAnErrorOfTheDisk)
{
  const Status error = Catch([] { throw std::bad_alloc(); });
  EXPECT_EQ(error.GetCode(), StatusCode::OutOfMemory);
  EXPECT_EQ(error.GetMessage(), "a.bvol: there is not enough memory");
  const Status length = Catch([] { throw std::bad_array_new_length(); });
  EXPECT_EQ(length.GetCode(), StatusCode::OutOfMemory);
}

TEST(Status, AnExceptionOfTheSystemKeepsItsWords)
{
  const Status error = Catch(
    []
    {
      throw std::system_error(
        std::make_error_code(std::errc::resource_unavailable_try_again), "thread");
    });
  ExpectError(error, StatusCode::IoError, "a.bvol: thread");
}

TEST(Status, OnlyADiskWithoutRoomIsAFullDisk)
{
  for (const int error : { ENOSPC, EDQUOT, EFBIG })
  {
    EXPECT_EQ(MakeSystemError("a", "write", error).GetCode(), StatusCode::DiskFull) << error;
  }
  for (const int error : { EIO, EACCES, EMFILE, EROFS })
  {
    EXPECT_EQ(MakeSystemError("a", "write", error).GetCode(), StatusCode::IoError) << error;
  }
  EXPECT_EQ(MakeSystemError("a", "read", ENOENT).GetCode(), StatusCode::NotFound);
  EXPECT_EQ(MakeSystemError("a", "read", ENOMEM).GetCode(), StatusCode::OutOfMemory);
}

} // namespace

TEST(PrintableText, HasNothingThatATerminalObeys)
{
  EXPECT_EQ(MakePrintable("a\x1b]0;title\x07 b\r\x7f\nc"), "a\\x1b]0;title\\x07 b\\x0d\\x7f\nc");
  EXPECT_EQ(MakePrintable("\xc2\x9b"
                          "31m \xc2\xb5m \xe2\x80\x9c"),
    "\\x9b31m \xc2\xb5m \xe2\x80\x9c");
  EXPECT_EQ(MakePrintable(std::string("\0", 1) + "\xc2"), "\\x00\xc2");
}
