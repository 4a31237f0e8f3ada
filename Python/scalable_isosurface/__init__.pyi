from .IsosurfaceFilters import (
    vtkContourSpectrum as vtkContourSpectrum,
    vtkDistributeIsosurface as vtkDistributeIsosurface,
    vtkStabbingContour as vtkStabbingContour,
)
from .IsosurfaceReaders import (
    vtkBlockedVolumeReader as vtkBlockedVolumeReader,
    vtkEdgeIndexReader as vtkEdgeIndexReader,
)
from .IsosurfaceRendering import (
    vtkMetabufferPass as vtkMetabufferPass,
    vtkMetabufferPVSynchronizedRenderer as vtkMetabufferPVSynchronizedRenderer,
    vtkMetabufferRenderView as vtkMetabufferRenderView,
    vtkMetabufferSynchronizedRenderers as vtkMetabufferSynchronizedRenderers,
)
from .IsosurfaceRepresentation import (
    vtkIsosurfaceCompositeRepresentation as vtkIsosurfaceCompositeRepresentation,
    vtkIsosurfaceMapper as vtkIsosurfaceMapper,
    vtkIsosurfaceRepresentation as vtkIsosurfaceRepresentation,
)
from .IsosurfaceWriters import (
    vtkBlockedVolumeWriter as vtkBlockedVolumeWriter,
    vtkEdgeIndexWriter as vtkEdgeIndexWriter,
)

__version__: str
