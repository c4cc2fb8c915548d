#!/usr/bin/env python3
"""VTK drawing one mesh in its own colours before a camera that goes round it: the baseline beside character_bench.

xvfb-run -a python3 vtk_drawing.py MESH.ply [PICTURES]     720 x 576; prints pictures a second and CPU time a picture
"""
import sys
import time

import vtk


def window_with(mesh_file):
    reader = vtk.vtkPLYReader()
    reader.SetFileName(mesh_file)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(reader.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    actor.GetProperty().BackfaceCullingOn()
    renderer = vtk.vtkRenderer()
    renderer.AddActor(actor)
    renderer.SetBackground(24 / 255, 26 / 255, 30 / 255)
    camera = renderer.GetActiveCamera()
    camera.SetViewUp(0, 0, 1)
    camera.SetPosition(0, -1, 0)
    camera.SetFocalPoint(0, 0, 0)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)  # as in the program it is compared with
    window.SetSize(720, 576)
    window.AddRenderer(renderer)
    renderer.ResetCamera()
    return window, camera


def main():
    pictures = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    window, camera = window_with(sys.argv[1])
    for _ in range(5):
        window.Render()
    window.WaitForCompletion()
    wall, cpu = time.monotonic(), time.process_time()
    for _ in range(pictures):
        camera.Azimuth(1)
        window.Render()
    window.WaitForCompletion()
    wall, cpu = time.monotonic() - wall, time.process_time() - cpu
    print(f"{pictures / wall:.1f} {1000 * cpu / pictures:.1f}")


if __name__ == "__main__":
    main()
