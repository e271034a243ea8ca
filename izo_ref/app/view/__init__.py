"""The page that shows a step or an animation in 3D, before and after.

May import what `app` may. Start with `page.py`; `page.html`, `page.css` and `js/` are what it is
made of, and `three/` is the library three.js.
"""
