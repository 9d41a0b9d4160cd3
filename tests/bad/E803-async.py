from helper import *
async def f():
    pass
@register()
async def a():
    return primitive_call("cube")
