from __future__ import annotations
import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import chi2
from vslam.loop_closing.closer import closures
from vslam.loop_closing.local_map import LocalMap
from vslam.loop_closing.record import Fragments, Record
from vslam.loop_closing.smoother import Estimate, smooth, squared_distances
from vslam.geometry import to_global, to_local
from vslam.motion import move

WINDOW_M, STRIDE_M, SIGHTS = 8.0, 4.0, 3

class ConstellationSlam:
    def __init__(self, gate=0.99, new_gate=0.9999, vague=.25, verbose=False):
        self.local=LocalMap(gate,new_gate,1.0,vague); self.record=Record(); self.fragments=Fragments()
        self.new_gate=new_gate; self.gate=gate
        self.travelled=[0.0]; self.keyframe_at=0.0; self.poses=np.zeros((1,3)); self.smoothed_to=0
        self.landmarks={}; self.keyframes=[]; self.online=[]; self.verbose=verbose; self.closed=[]
    def step(self,u,o):
        t=self.local.step(u,o); k=len(self.record.odometry)
        self.record.add(u,o,t)
        pose=move(self.poses[-1],u.delta); self.poses=np.vstack([self.poses,pose])
        for f,z in zip(t.tolist(),o.points):
            if f>=0:
                self.fragments.see(f,k)
                if f not in self.landmarks: self.landmarks[f]=to_global(pose,z[None])[0]
        self.online.append(pose)
        self.travelled.append(self.travelled[-1]+float(np.hypot(*u.delta[:2])))
        if self.travelled[-1]-self.keyframe_at>=STRIDE_M:
            self.keyframe_at=self.travelled[-1]; self.keyframe(k)
            self.online[-1]=self.poses[-1]
    def labels(self):
        roots=self.fragments.roots(); used=np.unique(roots)
        number=np.full(len(roots),-1); number[used]=np.arange(len(used))
        return used,[np.where(t>=0,number[roots[t]],-1) if len(roots) else t for t in self.record.tracks]
    def solve(self,tol=1e-2,it=20):
        used,labels=self.labels()
        e=smooth(self.record.problem(labels),self.poses,np.array([self.landmarks[f] for f in used]).reshape(-1,2),iterations=it,tolerance=tol)
        self.poses=e.poses
        for f,p in zip(used.tolist(),e.landmarks): self.landmarks[f]=p
        return e,used,labels
    def keyframe(self,k):
        self.keyframes.append(k)
        e,used,labels=self.solve()
        if self.query(k,e,used,labels): self.solve()
    def query(self,k,e,used,labels,both=False):
        s=self.travelled[k+1]
        lo=int(np.searchsorted(self.travelled,s-WINDOW_M))
        window=np.unique(np.concatenate([np.zeros(0,dtype=np.int64),*labels[lo:k+1]])); window=window[window>=0]
        sights=self.fragments.sights()[used]
        q=window[sights[window]>=SIGHTS]
        others=np.setdiff1d(np.flatnonzero(sights>=SIGHTS),window)
        if both:
            centre=e.landmarks[q]; pass
        n=0
        # newly seen alone: others must have been seen before
        if not both:
            pass
        pairs=closures(e,q,others,self.new_gate)
        for a,b in pairs: n+=self.fragments.merge(int(used[a]),int(used[b]))
        if n: self.closed.append((k,n,[(int(used[a]),int(used[b])) for a,b in pairs]))
        return n
