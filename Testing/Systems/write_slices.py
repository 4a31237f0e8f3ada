# SPDX-License-Identifier: BSD-3-Clause
"""Writes samples of float32 as a folder of DICOM, a file a slice: write_slices.py RAW X Y Z FOLDER"""
import os
import sys

import numpy
import pydicom
from pydicom.uid import ExplicitVRLittleEndian, generate_uid

raw, sides, folder = sys.argv[1], [int(side) for side in sys.argv[2:5]], sys.argv[5]
samples = numpy.fromfile(raw, "f4").reshape(sides[::-1]).astype("i2")
os.makedirs(folder)
study, series = generate_uid(), generate_uid()
for number, image in enumerate(samples):
    data = pydicom.Dataset()
    data.file_meta = pydicom.dataset.FileMetaDataset()
    data.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    data.file_meta.MediaStorageSOPClassUID = data.SOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
    data.file_meta.MediaStorageSOPInstanceUID = data.SOPInstanceUID = generate_uid()
    data.StudyInstanceUID, data.SeriesInstanceUID, data.Modality = study, series, "CT"
    data.ImageOrientationPatient, data.ImagePositionPatient = [1, 0, 0, 0, 1, 0], [0, 0, number]
    data.PixelSpacing, data.SliceThickness, data.InstanceNumber = [1, 1], 1, number + 1
    data.RescaleSlope, data.RescaleIntercept = 1, 0
    data.Rows, data.Columns = image.shape
    data.SamplesPerPixel, data.PhotometricInterpretation, data.PixelRepresentation = 1, "MONOCHROME2", 1
    data.BitsAllocated = data.BitsStored = 16
    data.HighBit = 15
    data.PixelData = image.tobytes()
    data.is_little_endian, data.is_implicit_VR = True, False
    data.save_as(os.path.join(folder, f"{number}.dcm"), write_like_original=False)
