#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""BigTIFF beyond 4 GiB, and files of tifffile, read by blockvolume: check_tiff.py TOOL MPIEXEC SCRATCH CLAIM"""
import json
import os
import struct
import sys

import h5py
import numpy
import tifffile

from sample_volumes import SourceCase, make_samples, remove_volume, run_claim

SHAPE = (7, 21, 34)  # z, y, x
ARRAY = "Tiff Scalars"


def make_images(*count, dtype="uint16"):
    """An image for each number, of other samples each."""
    total = int(numpy.prod(count))
    images = [make_samples(dtype, SHAPE, phase=0.7 * number) for number in range(total)]
    return numpy.stack(images).reshape(*count, *SHAPE)


class TiffCase(SourceCase):
    def assert_image(self, source, samples, *arguments, array=ARRAY, told=(), untold=(), unit=None, **place):
        """A volume of these samples alone; standard error has some words and not others."""
        path = self.path("o.bvol")
        remove_volume(path)
        code, _, err = self.run_tool(source, path, "--stores", "3", *arguments)
        self.assertEqual(code, 0, err)
        for word in told:
            self.assertIn(word, err)
        for word in untold:
            self.assertNotIn(word, err)
        self.assert_equal_volumes(path, self.write_raw(samples, array, *(["--unit", unit] if unit else []), **place))

    def list_images(self, source):
        code, out, err = self.run_tool("--list", source)
        self.assertEqual(code, 0, err)
        return [[word.strip() for word in line.split("  ") if word.strip()] for line in out.splitlines()]

    def find_info(self, source, *arguments):
        path = self.write(source, "i.bvol", *arguments)
        return json.loads(self.run_tool("--info", "--json", path)[1])

    def write_pages(self, name, pages, description, **tags):
        """Pages in their order, with a text on the first one alone."""
        with tifffile.TiffWriter(self.path(name), **tags.pop("file", {})) as file:
            for number, page in enumerate(pages):
                file.write(page, description=description if number == 0 else "", metadata=None,
                           contiguous=False, **tags)


def make_ome(pixels, data, sizes, attributes="", uuid="", order="XYZCT", images=1):
    """OME-XML of images of these sizes on z, c and t."""
    text = (f'<Pixels ID="Pixels:0" DimensionOrder="{order}" Type="uint16" SizeX="{pixels[1]}" '
            f'SizeY="{pixels[0]}" SizeZ="{sizes[0]}" SizeC="{sizes[1]}" SizeT="{sizes[2]}" {attributes}>'
            f'{data}</Pixels>')
    return ('<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" '
            f'UUID="urn:uuid:{uuid}">' + f'<Image ID="Image:0" Name="first">{text}</Image>' * images + "</OME>")


class OmeTiff(TiffCase):
    def test_images_are_read_one_by_one(self):
        first, second = make_images(2)
        with tifffile.TiffWriter(self.path("two.ome.tif"), ome=True) as file:
            for number, image in enumerate((first, second)):
                file.write(image, metadata={"axes": "ZYX", "Name": f"position {number + 1}"})
        self.assert_image("two.ome.tif", first, told=("the first of 2 images", "position 1, position 2"))
        for name in ("position 2", "1", "Image:1"):
            self.assert_image("two.ome.tif:" + name, second, untold=("the first of",))
        self.assertEqual([line[:3] for line in self.list_images("two.ome.tif")],
                         [["position 1", "7 x 21 x 34", "uint16"], ["position 2", "7 x 21 x 34", "uint16"]])
        self.assert_error("two.ome.tif:position 3", "two.ome.tif:position 3", "no such image",
                          "position 1, position 2")
        # Images of other sizes do not hinder the first one.
        with tifffile.TiffWriter(self.path("sizes.ome.tif"), ome=True) as file:
            file.write(first, metadata={"axes": "ZYX"})
            file.write(numpy.zeros((3, 8, 9), "uint8"), metadata={"axes": "ZYX"})
        self.assert_image("sizes.ome.tif", first)
        self.assert_image("sizes.ome.tif:1", numpy.zeros((3, 8, 9), "uint8"))

    def test_pages_lie_in_each_of_the_six_orders(self):
        images = make_images(2, 3)  # t, c
        for order in ("ZCT", "ZTC", "CZT", "CTZ", "TZC", "TCZ"):
            with self.subTest(order=order):
                axes = [{"T": 0, "C": 1, "Z": 2}[letter] for letter in order[::-1]]
                pages = images.transpose(*axes, 3, 4).reshape(-1, *SHAPE[1:])
                self.write_pages("o.ome.tif", pages, make_ome(SHAPE[1:], "<TiffData/>", (7, 3, 2), order="XY" + order))
                series = tifffile.imread(self.path("o.ome.tif"))
                self.assertEqual(series.size, images.size)
                info = self.find_info("o.ome.tif")
                self.assertEqual(len(info["timeSteps"]), 2)
                self.assertEqual([array["name"] for array in info["arrays"]],
                                 [f"{ARRAY} {number}" for number in range(3)])
                path = self.write("o.ome.tif", "step.bvol", "--step", "1", "--arrays", ARRAY + " 1")
                self.assert_equal_volumes(path, self.write_raw(images[1, 1], ARRAY + " 1", "--time", "1"))

    def test_pages_are_where_tiffdata_says(self):
        image = make_images(1)[0]
        backward = "".join(f'<TiffData FirstZ="{6 - page}" IFD="{page}"/>' for page in range(7))
        self.write_pages("back.ome.tif", image[::-1], make_ome(SHAPE[1:], backward, (7, 1, 1)))
        self.assert_image("back.ome.tif", image)
        parts = '<TiffData FirstZ="4" IFD="0" PlaneCount="3"/><TiffData FirstZ="0" IFD="3" PlaneCount="4"/>'
        self.write_pages("parts.ome.tif", numpy.concatenate([image[4:], image[:4]]),
                         make_ome(SHAPE[1:], parts, (7, 1, 1)))
        self.assert_image("parts.ome.tif", image)
        self.write_pages("short.ome.tif", image[:5], make_ome(SHAPE[1:], "<TiffData/>", (7, 1, 1)))
        self.assert_error("short.ome.tif", "short.ome.tif", "truncated", "slice 6 of 7")
        self.write_pages("far.ome.tif", image, make_ome(SHAPE[1:], '<TiffData IFD="1" PlaneCount="7"/>', (7, 1, 1)))
        self.assert_error("far.ome.tif", "truncated", "page 8")

    def test_an_image_in_several_files_is_read_from_each_of_them(self):
        image, other = make_images(2)
        data = "".join(f'<TiffData FirstZ="{first}" FirstC="{channel}" IFD="0" PlaneCount="{count}">'
                       f'<UUID FileName="{name}.ome.tif">urn:uuid:{name}</UUID></TiffData>'
                       for name, first, channel, count in
                       (("a", 0, 0, 4), ("b", 4, 0, 3), ("c", 0, 1, 7)))
        names = '<Channel ID="Channel:0:0" Name="DAPI"/><Channel ID="Channel:0:1" Name="GFP"/>'
        for name, pages in (("a", image[:4]), ("b", image[4:]), ("c", other)):
            self.write_pages(name + ".ome.tif", pages, make_ome(SHAPE[1:], names + data, (7, 2, 1), uuid=name))
        for name in "abc":
            self.assert_image(name + ".ome.tif", image, "--arrays", "DAPI", array="DAPI")
        self.assert_image("a.ome.tif", other, "--arrays", "GFP", array="GFP")
        os.rename(self.path("a.ome.tif"), self.path("renamed.ome.tif"))
        self.assert_image("renamed.ome.tif", image, "--arrays", "DAPI", array="DAPI")
        os.remove(self.path("c.ome.tif"))
        self.assert_error("renamed.ome.tif", "c.ome.tif")
        # A file without metadata of its own.
        with open(self.path("set.companion.ome"), "w", encoding="utf-8") as file:
            file.write(make_ome(SHAPE[1:], data.replace("a.ome", "d.ome").replace("c.ome", "d.ome").replace(
                'FirstZ="0" FirstC="1" IFD="0" PlaneCount="7"', 'FirstZ="0" FirstC="1" IFD="4" PlaneCount="7"'),
                (7, 2, 1), uuid="set"))
        self.write_pages("d.ome.tif", numpy.concatenate([image[:4], other]),
                         '<OME UUID="urn:uuid:d"><BinaryOnly MetadataFile="set.companion.ome" UUID="urn:uuid:set"/></OME>')
        self.assert_image("d.ome.tif", other, "--arrays", ARRAY + " 1", array=ARRAY + " 1")

    def test_lengths_and_times_are_those_of_the_pixels(self):
        images = make_images(3)
        with tifffile.TiffWriter(self.path("t.ome.tif"), ome=True) as file:
            file.write(images, metadata={
                "axes": "TZYX", "PhysicalSizeX": 0.25, "PhysicalSizeY": 0.5, "PhysicalSizeYUnit": "µm",
                "PhysicalSizeZ": 750, "PhysicalSizeZUnit": "nm", "TimeIncrement": 0.5, "TimeIncrementUnit": "min"})
        info = self.find_info("t.ome.tif")
        self.assertEqual([step["time"] for step in info["timeSteps"]], [0, 0.5, 1])
        self.assertEqual(info["grid"]["unit"], "um")
        self.assertTrue(numpy.allclose(info["grid"]["spacing"], [0.25, 0.5, 0.75], rtol=1e-12))
        err = self.run_tool("t.ome.tif", "u.bvol")[2]
        self.assertIn("min", err)
        self.write_pages("alone.ome.tif", images.reshape(-1, *SHAPE[1:]), make_ome(
            SHAPE[1:], "<TiffData/>", (7, 1, 3), 'TimeIncrement="4"'))
        self.assertEqual([step["time"] for step in self.find_info("alone.ome.tif")["timeSteps"]], [0, 4, 8])
        self.write_pages("flat.ome.tif", images[0], make_ome(
            SHAPE[1:], "<TiffData/>", (7, 1, 1), 'PhysicalSizeX="2" PhysicalSizeY="2"'))
        self.assert_image("flat.ome.tif", images[0], told=("PhysicalSizeZ of OME-XML is missing",), unit="um",
                          spacing=(2, 2, 1))

    def test_stacks_of_one_kind_of_pages_are_slices(self):
        image = make_images(1)[0]
        for sizes, kind in (((1, 7, 1), "channels"), ((1, 1, 7), "frames")):
            self.write_pages("k.ome.tif", image, make_ome(SHAPE[1:], "<TiffData/>", sizes))
            self.assert_image("k.ome.tif", image, told=(kind, "taken as slices"))
        self.write_pages("both.ome.tif", image[:6], make_ome(SHAPE[1:], "<TiffData/>", (1, 2, 3)))
        self.assert_error("both.ome.tif", "2 channels, 1 slices and 3 frames: there is no stack of slices")

    def test_pages_of_other_files_may_be_missing(self):
        image = make_images(1)[0]
        self.write_pages("set.ome.tif", image, make_ome(SHAPE[1:], "<TiffData/>", (7, 2, 1)))
        self.assert_image("set.ome.tif", image, array=ARRAY + " 0", told=("channels whose pages are in other files",))
        # A page of several is none of a stack; in a stack of files it is a slice, of whatever.
        for number, page in enumerate(image):
            self.write_pages(f"q{number}.tif", image[number:number + 1], make_ome(SHAPE[1:], "<TiffData/>", (2, 2, 1)))
        self.assert_error("q1.tif", "q1.tif", "truncated: slice 2 of 2 of channel 0")
        self.assert_image("q*.tif", image)

    def test_hostile_xml_is_one_error(self):
        image = make_images(1)[0]
        bomb = '<!DOCTYPE x [<!ENTITY a "' + "a" * 1000 + '">' + "".join(
            f'<!ENTITY b{number} "{"&a;" * 1000}">' for number in range(50)) + "]>"
        ome = make_ome(SHAPE[1:], "<TiffData/>", (7, 1, 1))
        self.write_pages("bomb.ome.tif", image, ome.replace("<OME", bomb + "<OME").replace("first", "&b1;"))
        self.assert_image("bomb.ome.tif", image)

        def refuse(data, *words, sizes=(7, 1, 1), uuid="own"):
            self.write_pages("h.ome.tif", image, make_ome(SHAPE[1:], data, sizes, uuid=uuid))
            self.assert_error("h.ome.tif", "h.ome.tif", *words)
        outside = '<TiffData IFD="0"><UUID FileName="{}">urn:uuid:x</UUID></TiffData>'
        for name in ("../a.tif", "/etc/passwd", "..\\a.tif", ".."):
            refuse(outside.format(name), "outside of its folder")
        refuse('<TiffData><UUID>urn:uuid:x</UUID></TiffData>', "UUID alone")
        refuse('<TiffData FirstZ="7"/>', "FirstZ")
        refuse('<TiffData IFD="-1"/>', "IFD")
        refuse('<TiffData IFD="0" PlaneCount="2000000000"/>' * 20, "more pages")
        refuse('<TiffData IFD="99999999999999999999"/>', "IFD")
        refuse("<TiffData/>", "planes", sizes=(2000000000, 2000000000, 2000000000))
        refuse("<TiffData/>", "SizeZ", sizes=(0, 1, 1))
        refuse('<TiffData FirstZ="1" IFD="0" PlaneCount="7"/>', "more pages")
        self.write_pages("cut.ome.tif", image, ome[:200] + "</OME>")
        self.assert_error("cut.ome.tif", "OME-XML cannot be read")
        self.write_pages("other.ome.tif", image, '<OME><BinaryOnly MetadataFile="other.ome.tif" UUID="u"/></OME>')
        self.assert_error("other.ome.tif", "another file again")


class ImageJ(TiffCase):
    def test_hyperstacks_have_channels_slices_and_frames(self):
        images = make_images(2, 3)  # t, c
        for order in "<>":
            tifffile.imwrite(self.path("h.tif"), images.transpose(0, 2, 1, 3, 4), imagej=True, byteorder=order,
                             resolution=(4, 2), metadata={"axes": "TZCYX", "spacing": 0.75, "unit": "um", "finterval": 2.5})
            info = self.find_info("h.tif")
            self.assertEqual([step["time"] for step in info["timeSteps"]], [0, 2.5])
            path = self.write("h.tif", "o.bvol", "--step", "1", "--arrays", ARRAY + " 2")
            self.assert_equal_volumes(path, self.write_raw(
                images[1, 2], ARRAY + " 2", "--time", "2.5", "--unit", "um", spacing=(0.25, 0.5, 0.75)))

    def test_a_single_directory_stands_for_all_images(self):
        images = make_images(2)  # c
        text = "ImageJ=1.53t\nimages=14\nchannels=2\nslices=7\nhyperstack=true\nunit=\\u00B5m\nspacing=2.0\n"
        pages = images.transpose(1, 0, 2, 3).astype(">u2").reshape(-1, SHAPE[2])
        with tifffile.TiffWriter(self.path("s.tif"), byteorder=">") as file:
            file.write(numpy.zeros(SHAPE[1:], "uint16"), description=text, metadata=None, resolution=(2, 2))
        with tifffile.TiffFile(self.path("s.tif")) as file:
            place, strip = file.pages[0].dataoffsets[0], file.pages[0].tags[273]
        self.assertEqual(strip.value[0], place)
        with open(self.path("s.tif"), "r+b") as file:
            begin = file.seek(0, os.SEEK_END)
            file.write(pages.tobytes())
            file.seek(strip.offset + 8)
            file.write(struct.pack(">I", begin))
        self.assert_image("s.tif", images[1], "--arrays", ARRAY + " 1", array=ARRAY + " 1", unit="um",
                          spacing=(0.5, 0.5, 2))
        os.truncate(self.path("s.tif"), begin + pages.nbytes - 1)
        self.assert_error("s.tif", "s.tif", "truncated")

    def test_numbers_of_images_that_the_pages_do_not_have(self):
        pages = make_images(1)[0][:6]
        self.write_pages("n.tif", pages, "ImageJ=1.53t\nimages=8\nchannels=2\nslices=4\n")
        self.assert_error("n.tif", "n.tif", "2 channels, 4 slices and 1 frames, but there are 6 pages")
        self.write_pages("t.tif", pages, "channels=2\nslices=3\n")  # not of ImageJ
        self.assert_image("t.tif", pages)

    def test_stacks_of_one_kind_of_pages_are_slices(self):
        image = make_images(1)[0]
        for axes in ("ZYX", "CYX", "TYX"):
            tifffile.imwrite(self.path("k.tif"), image, imagej=True, metadata={"axes": axes})
            self.assert_image("k.tif", image, told=() if axes == "ZYX" else ("taken as slices",),
                              untold=("taken as slices",) if axes == "ZYX" else ())

    def test_signed_samples_of_16_bits_and_calibrations(self):
        image = make_images(1, dtype="int16")[0] - 40
        text = "ImageJ=1.53t\nimages=7\nslices=7\ncf=0\nc0=-32768\nc1=1\nvunit=Gray Value\n"
        self.write_pages("c.tif", (image.astype("int32") + 32768).astype("uint16"), text)
        self.assert_image("c.tif", image)
        self.write_pages("f.tif", make_images(1)[0], text.replace("c1=1", "c1=2"))
        self.assert_image("f.tif", make_images(1)[0], told=("calibration", "not applied"))

    def test_palettes_of_imagej_are_for_showing(self):
        image = make_images(1, dtype="uint8")[0]
        colors = numpy.zeros((3, 256), "uint16")
        for text, is_read in (("ImageJ=1.53t\nimages=7\nslices=7\n", True), ("", False)):
            self.write_pages("p.tif", image, text, photometric="palette", colormap=colors)
            if is_read:
                self.assert_image("p.tif", image, told=("colours",))
            else:
                self.assert_error("p.tif", "p.tif", "page 1", "palette")


class Tifffile(TiffCase):
    def test_axes_are_those_of_the_description(self):
        images = make_images(2, 3)  # t, c
        for axes, order in (("TCZYX", (0, 1, 2)), ("TZCYX", (0, 2, 1)), ("CZTYX", (1, 2, 0)), ("ZCTYX", (2, 1, 0))):
            tifffile.imwrite(self.path("a.tif"), images.transpose(*order, 3, 4), photometric="minisblack",
                             metadata={"axes": axes})
            path = self.write("a.tif", "o.bvol", "--step", "1", "--arrays", ARRAY + " 2")
            self.assert_equal_volumes(path, self.write_raw(images[1, 2], ARRAY + " 2", "--time", "1"))
        info = self.find_info("a.tif")
        self.assertEqual((len(info["timeSteps"]), len(info["arrays"])), (2, 3))
        channels = images[0]
        tifffile.imwrite(self.path("c.tif"), channels, metadata={"axes": "CZYX"})
        self.assert_image("c.tif", channels[1], "--arrays", ARRAY + " 1", array=ARRAY + " 1")
        for axes in ("QYX", "IYX", "ZYX", "YX", "CYX"):
            tifffile.imwrite(self.path("z.tif"), channels[0], metadata={"axes": axes} if len(axes) == 3 else {})
            self.assert_image("z.tif", channels[0])

    def test_unknown_axes_are_refused_by_name(self):
        images = make_images(2)
        tifffile.imwrite(self.path("r.tif"), images, metadata={"axes": "RZYX"})
        self.assert_error("r.tif", "r.tif", "RZYX", "\"R\"", "--axes")
        self.assert_image("r.tif", images[1], "--axes", "czyx", "--arrays", ARRAY + " 1", array=ARRAY + " 1")
        self.assert_error("r.tif", "axes of pages", arguments=["--axes", "tczyx"])

    def test_images_are_read_one_by_one(self):
        first, second = make_images(2)
        with tifffile.TiffWriter(self.path("two.tif")) as file:
            file.write(first)
            file.write(second)
        self.assert_image("two.tif", first, told=("the first of 2 images",))
        self.assert_image("two.tif:1", second)
        self.assertEqual([line[0] for line in self.list_images("two.tif")], ["0", "1"])
        with tifffile.TiffWriter(self.path("pages.tif")) as file:
            for page in first:
                file.write(page, contiguous=False)
        self.assert_image("pages.tif", first, told=("7 images of a page each",))

    def test_a_single_directory_stands_for_all_pages(self):
        images = make_images(2)
        with tifffile.TiffWriter(self.path("t.tif")) as file:
            file.write(images, truncate=True, metadata={"axes": "CZYX"})
        self.assert_image("t.tif", images[1], "--arrays", ARRAY + " 1", array=ARRAY + " 1")

    def test_samples_of_a_pixel_are_components_or_arrays(self):
        channels = make_images(3)  # c
        for layout in ({}, {"compression": "zlib"}, {"tile": (16, 16)}):
            for order in "<>":
                tifffile.imwrite(self.path("p.tif"), channels.transpose(1, 0, 2, 3), photometric="minisblack",
                                 planarconfig="separate", byteorder=order, **layout)
                self.assert_image("p.tif", channels[2], "--arrays", ARRAY + " 2", array=ARRAY + " 2")
                tifffile.imwrite(self.path("q.tif"), channels.transpose(1, 2, 3, 0), photometric="minisblack",
                                 planarconfig="contig", byteorder=order, **layout)
                with h5py.File(self.path("q.h5"), "w") as file:
                    file[ARRAY] = channels.transpose(1, 2, 3, 0)
                self.assert_equal_volumes(self.write("q.tif", "o.bvol"),
                                          self.write("q.h5:/" + ARRAY, "h.bvol", "--axes", "zyxc"))


class TagsOfPages(TiffCase):
    def test_what_is_not_obeyed_is_told(self):
        image = make_images(1)[0]
        for tag, word in (((274, 3, 1, 4, True), "Orientation (4)"), ((33550, 12, 3, (2.0, 2.0, 0.0), True), "GeoTIFF"),
                          ((42113, 2, 0, "-9999", True), "GDAL_NODATA, -9999"),
                          ((34412, 1, 4, b"abcd", True), "Zeiss LSM"), ((51123, 2, 0, "{}", True), "Micro-Manager")):
            self.write_pages("t.tif", image, "", extratags=[tag])
            self.assert_image("t.tif", image, told=(word,))
        self.write_pages("w.tif", image, "", photometric="miniswhite")
        self.assert_image("w.tif", image, told=("0 is white",))
        self.write_pages("s.tif", image, "", software="SI.VERSION_MAJOR = '2018b'")
        self.assert_image("s.tif", image, told=("ScanImage",))
        self.write_pages("r.tif", image, "", resolution=(100, 100), resolutionunit="CENTIMETER")
        self.assert_image("r.tif", image, told=("100 x 100 pixels per cm",))
        self.write_pages("n.tif", image, "")
        self.assert_image("n.tif", image, untold=("n.tif:",))

    def test_pages_that_hold_several_slices_are_refused(self):
        image = make_images(1)[0]
        self.write_pages("m.tif", image[:1], "", extratags=[(33629, 4, 2, (7, 7), True)])
        self.assert_error("m.tif", "m.tif", "MetaMorph", "in one page")
        with tifffile.TiffWriter(self.path("v.tif")) as file:
            file.write(numpy.zeros((16, 16, 16), "uint8"), volumetric=True, tile=(16, 16, 16))
        self.assert_error("v.tif", "v.tif", "pages of several slices")

    def test_thumbnails_among_the_pages_are_left_out(self):
        image = make_images(1)[0]
        with tifffile.TiffWriter(self.path("t.tif")) as file:
            for page in image:
                file.write(page, metadata=None, contiguous=False)
                file.write(numpy.full((3, 4, 3), 200, "uint8"), metadata=None, contiguous=False, photometric="rgb",
                           subfiletype=1)
        self.assert_image("t.tif", image)

    def test_a_type_that_the_pages_do_not_have_is_told(self):
        image = make_images(1)[0]
        self.write_pages("t.ome.tif", image, make_ome(SHAPE[1:], "<TiffData/>", (7, 1, 1)).replace("uint16", "int16"))
        self.assert_image("t.ome.tif", image, told=("samples are uint16, although OME-XML says int16",))

    def test_colors_and_small_samples_are_refused_by_name(self):
        image = make_images(1, dtype="uint8")[0]
        self.write_pages("rgb.tif", numpy.stack([image] * 3, axis=3), "", photometric="rgb")
        self.assert_error("rgb.tif", "rgb.tif", "page 1", "RGB")
        self.write_pages("bits.tif", image > 50, "")
        self.assert_error("bits.tif", "bits.tif", "samples of 1 bits")
        self.write_pages("half.tif", image.astype("float16"), "")
        self.assert_error("half.tif", "half.tif", "samples of 16 bits (SampleFormat 3)")


class Sparse(TiffCase):
    def test_strips_and_tiles_that_are_missing_have_gdals_number_or_zero(self):
        layouts = [{"rowsperstrip": 4}, {"rowsperstrip": 4, "compression": "zlib"}, {"tile": (16, 16)},
                   {"tile": (16, 16), "compression": "zlib"}]
        files = [{"byteorder": "<"}, {"byteorder": ">"}, {"byteorder": ">", "bigtiff": True}]
        cases = (("uint16", None, 0), ("uint16", "65535 ", 65535), ("uint16", "-9999", 0), ("uint16", "65536", 0),
                 ("uint16", "nan", 0), ("int16", "-9999", -9999), ("uint64", "18446744073709551615", 2**64 - 1),
                 ("float32", "-3.4028235e+38", numpy.finfo("float32").min), ("float32", "1e40", 0),
                 ("float64", "-1.5", -1.5), ("float64", "none", 0))
        for number, (dtype, text, fill) in enumerate(cases):
            layout, file = layouts[number % 4], files[number % 3]
            with self.subTest(dtype=dtype, text=text, layout=layout, file=file):
                image = make_images(1, dtype=dtype)[0]
                self.write_pages("s.tif", image, "", file=file, **layout,
                                 extratags=[(42113, 2, 0, text, False)] if text else [])
                height, width = layout.get("tile", (4, SHAPE[2]))
                across = -(-SHAPE[2] // width)
                with tifffile.TiffFile(self.path("s.tif"), mode="r+b") as tiff:
                    for k, page in enumerate(tiff.pages):
                        for name in (("TileOffsets", "TileByteCounts") if "tile" in layout else
                                     ("StripOffsets", "StripByteCounts")):
                            values = list(page.tags[name].value)
                            values[k % 2::2] = [0] * len(values[k % 2::2])
                            page.tags[name].overwrite(values)
                        for missing in range(k % 2, len(values), 2):
                            y, x = missing // across * height, missing % across * width
                            image[k, y:y + height, x:x + width] = fill
                self.assert_image("s.tif", image, told=("GDAL_NODATA",) if text else ())


class BigTiff(SourceCase):
    def test_pages_beyond_4_gib_of_a_sparse_file(self):
        samples = make_samples("uint16", (5, 37, 70))
        for order in "<>":
            with self.subTest(order=order), open(self.path("big.tif"), "wb") as file:
                # Directory and samples of each page 2 GiB after those of the page before.
                places = [16 + (2 << 30) * page for page in range(len(samples))]
                mark = b"II" if order == "<" else b"MM"
                file.write(mark + struct.pack(order + "HHHQ", 43, 8, 0, places[0]))
                for page, place in enumerate(places):
                    data = samples[page].astype(samples.dtype.newbyteorder(order)).tobytes()
                    tags = [(256, 70), (257, 37), (258, 16), (259, 1), (262, 1), (273, place + 4096),
                            (277, 1), (278, 37), (279, len(data)), (339, 1)]
                    text = struct.pack(order + "Q", len(tags))
                    for tag, value in tags:
                        text += struct.pack(order + "HHQQ", tag, 16, 1, value)
                    text += struct.pack(order + "Q", (places + [0])[page + 1])
                    file.seek(place)
                    file.write(text)
                    file.seek(place + 4096)
                    file.write(data)
                file.flush()
                self.assertGreater(os.path.getsize(file.name), 8 << 30)
                self.assert_equal_volumes(
                    self.write("big.tif", "o.bvol", ranks=2 if order == "<" else 1),
                    self.write_raw(samples, "Tiff Scalars"))


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
