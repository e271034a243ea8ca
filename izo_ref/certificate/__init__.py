"""The path certificate: each candidate pair is proved apart or proved to meet.

May import detection and the stages below it. It does not import `scene.py`; its functions take the
scene as `SceneArrays` of `base/records.py`. Start with `certify.py`; the exact arithmetic is in
`base/exact_path.py`.
"""
