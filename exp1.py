import sys,time,io,numpy as np
sys.path.insert(0,'/tmp/scratch-web')
import synth
from PIL import Image
from relume.core import library, view, measure, relight
from concurrent.futures import ThreadPoolExecutor
path=sys.argv[1]; noise=float(sys.argv[2])
t=time.time(); im=synth.image(path,noise); print('synth',time.time()-t,im.size)
model=im.model; p=model.channels
names=sum(library.illuminants().values(),[])
R=np.array([view.relight_matrix(model,library.illuminant(n)) for n in names])
wh=R.sum(2)
def metric():
    G=np.zeros((p,p))
    for r,w in zip(R,wh):
        J=relight.local_metric(.2*w[None],w)[0]
        A=.2*J@r; G+=A.T@A
    G/=len(R); return G+1e-4*np.trace(G)/p*np.eye(p)
G=metric(); ev,V=np.linalg.eigh(G); root=(V*np.sqrt(ev))@V.T; iroot=(V/np.sqrt(ev))@V.T
lum=np.maximum(R[:,1].mean(0),0); lum/=lum.sum()
rng=np.random.default_rng(0)
h,w=im.alpha.shape
crop=(slice(0,h),slice(0,w))
X0=.02
def prep(c,step):
    c=c.reshape(-1,p); I=c@lum
    scale=max(np.percentile(I,95),1e-6)
    eps=X0*scale
    n=(c-I[:,None])/(I+eps).clip(eps*.1)[:,None]
    cov=(n.T@n)/len(n)
    S=root@cov@root; l,U=np.linalg.eigh(S); U=U[:,::-1][:,:p-1]; l=l[::-1]
    r=n@root@U
    L=np.log1p(np.maximum(I,-eps*.5)/eps)
    planes=[]; 
    lo,hi=L.min(),L.max(); planes.append((L,lo,(hi-lo)/255))
    for j in range(p-1):
        a=r[:,j]; lo,hi=np.percentile(a,.02),np.percentile(a,99.98)
        s=max(step,(hi-lo)/255); planes.append((a,(lo+hi)/2-127.5*s,s))
    return planes,(eps,iroot@U),np.sqrt(l[:p-1])
def quant(planes): return [np.clip(np.round((a-lo)/s),0,255).astype(np.uint8).reshape(h,w) for a,lo,s in planes]
def deq(codes,planes): return [q.reshape(-1).astype(np.float32)*s+lo for q,(a,lo,s) in zip(codes,planes)]
def rebuild(vals,par):
    eps,B=par; I=eps*np.expm1(vals[0]); r=np.stack(vals[1:],1)
    return I[:,None]+(I+eps)[:,None]*(r@B.T)
idx=rng.choice(h*w,20000,replace=False)
def err(rec,exposure=0.0):
    out=[]
    for r,wt in zip(R,wh):
        to=view.xyz_to_rgb()
        a=sum(c.reshape(-1,p)[idx] for c in im.groups.values())@(to@r).T*2**exposure
        b=sum(c for c in rec)@(to@r).T*2**exposure
        M=np.linalg.inv(to); D=M.sum(1)
        d=measure.delta_E_2000(np.clip(a,0,1)@M.T,np.clip(b,0,1)@M.T,D)
        out.append((np.median(d),np.percentile(d,98)))
    o=np.array(out); return f"median {o[:,0].mean():.2f} worst {o[:,0].max():.2f}; p98 mean {o[:,1].mean():.2f} worst {o[:,1].max():.2f} ({names[o[:,1].argmax()]})"
def webp(q,qual): b=io.BytesIO(); Image.fromarray(q).convert('RGB').save(b,'WEBP',quality=qual,method=4); return b.getvalue()
def webpll(q,_): b=io.BytesIO(); Image.fromarray(q).convert('RGB').save(b,'WEBP',lossless=True,quality=50,method=3); return b.getvalue()
def avif(q,qual): b=io.BytesIO(); Image.fromarray(q).save(b,'AVIF',quality=qual,speed=7,max_threads=2); return b.getvalue()
def png(q,_): b=io.BytesIO(); Image.fromarray(q).save(b,'PNG',compress_level=6); return b.getvalue()
def run(enc,qual,step):
    total=0;rec=[];t=time.time();sizes=[]
    for c in im.groups.values():
        planes,par,sd=prep(c,step); codes=quant(planes)
        data=[enc(q,qual) for q in codes]; total+=sum(map(len,data)); sizes.append([len(d)//1000 for d in data])
        back=[np.asarray(Image.open(io.BytesIO(d)).convert('L')) for d in data]
        rec.append(rebuild([v[idx] for v in deq(back,planes)],par))
    print(enc.__name__,qual,'step',step,f'{total/1e6:.2f} MB {time.time()-t:.0f}s',err(rec),'| -4:',err(rec,-4.),flush=True)
    return sizes,sd
for g,c in im.groups.items():
    planes,par,sd=prep(c,.3); print(g,'steps',[round(float(s),3) for _,_,s in planes],'sd',np.round(sd,2))
print('quant only .3:',err([rebuild([v[idx] for v in deq(quant(P[0]),P[0])],P[1]) for P in [prep(c,.3) for c in im.groups.values()]]))
if len(sys.argv)>3:
  for line in sys.argv[3:]:
    e,q,s=line.split(','); sz,_=run(globals()[e],int(q),float(s)); print(sz)
