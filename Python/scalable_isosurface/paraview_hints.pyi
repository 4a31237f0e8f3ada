from .IsosurfaceRendering import (
    vtkMetabufferPass as vtkMetabufferPass,
    vtkMetabufferPVSynchronizedRenderer as vtkMetabufferPVSynchronizedRenderer,
    vtkMetabufferRenderView as vtkMetabufferRenderView,
    vtkMetabufferSynchronizedRenderers as vtkMetabufferSynchronizedRenderers,
)
from .IsosurfaceRepresentation import (
    vtkIsosurfaceCompositeRepresentation as vtkIsosurfaceCompositeRepresentation,
    vtkIsosurfaceRepresentation as vtkIsosurfaceRepresentation,
    vtkMiddleSlicesRepresentation as vtkMiddleSlicesRepresentation,
    vtkSMIsosurfaceRepresentationProxy as vtkSMIsosurfaceRepresentationProxy,
    vtkSMIsovalueDomain as vtkSMIsovalueDomain,
    vtkSMSampleArrayDomain as vtkSMSampleArrayDomain,
    vtkSMVolumeSliceRepresentationProxy as vtkSMVolumeSliceRepresentationProxy,
)
