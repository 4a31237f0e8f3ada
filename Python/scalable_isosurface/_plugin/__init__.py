# SPDX-License-Identifier: BSD-3-Clause
"""ScalableIsosurface in ParaView since 5.9, without a build: what the file ScalableIsosurface.py loads.

A class has the name of the one in C++, and `values` of the properties in the XML that both plugins have."""

from ._definitions import DEFINITIONS  # noqa: F401
from ._readers import vtkBlockedVolumeReader, vtkEdgeIndexReader, vtkInPlaceVolumeReader  # noqa: F401
from ._samples import vtkVolumeProbe, vtkVolumeRegion, vtkVolumeSlice  # noqa: F401
from ._surfaces import vtkContourSpectrum, vtkStabbingContour  # noqa: F401
from ._writers import vtkBlockedVolumeWriter, vtkEdgeIndexWriter  # noqa: F401
